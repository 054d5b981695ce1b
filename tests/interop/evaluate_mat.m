% Prints what a MAT file holds and runs its units: octave-cli evaluate_mat.m FILE POINTS OUTPUTS
args = argv();
load(args{1});
points = load('-ascii', args{2}); % of the inputs, scaled
degrees = @(u, t) exp(-[t.rate] .* max(abs(u - [t.centre]) - [t.half_width], 0) .^ 2);
outputs = zeros(rows(points), numel(units));
for k = 1:rows(points)
    values = points(k, :);
    for n = 1:numel(units)
        column = degrees(values(wiring(n, 1)), controller.terms);
        row = degrees(values(wiring(n, 2)), controller.terms);
        values(end + 1) = row * units(n).table * column' / (sum(row) * sum(column));
    end
    outputs(k, :) = values(end - numel(units) + 1:end);
end
dlmwrite(args{3}, outputs, 'precision', '%.17g');
