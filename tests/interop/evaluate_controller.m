% Commands of a folder's controller.m: octave-cli evaluate_controller.m FOLDER SIGNALS NAMES OUTPUTS
args = argv();
addpath(args{1});
values = load('-ascii', args{2});
names = strsplit(args{3}, ',');
state = [];
commands = zeros(rows(values), 1);
for k = 1:rows(values)
    signals = cell2struct(num2cell(values(k, :)), names, 2);
    [commands(k), state] = controller(signals, state);
end
dlmwrite(args{4}, commands, 'precision', '%.17g');
