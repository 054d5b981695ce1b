% Outputs of one .fis: octave-cli evaluate_fis.m FILE POINTS OUTPUTS
pkg load fuzzy-logic-toolkit
args = argv();
fis = readfis(args{1});
points = load('-ascii', args{2});
for k = 1:2 % what is beyond a range counts as its end, as in MATLAB
    range = fis.input(k).range;
    points(:, k) = min(max(points(:, k), range(1)), range(2));
end
dlmwrite(args{3}, evalfis(points, fis), 'precision', '%.17g');
