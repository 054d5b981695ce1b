% Commands of a folder's controller.m: octave-cli evaluate_controller.m FOLDER SIGNALS NAMES OUTPUTS
args = argv();
addpath(args{1});
values = load('-ascii', args{2});
names = strsplit(args{3}, ',');
state = [];
commands = [];
for k = 1:rows(values)
    signals = cell2struct(num2cell(values(k, :)), names, 2);
    [command, state] = controller(signals, state);
    commands(k, :) = command;
end
dlmwrite(args{4}, commands, 'precision', '%.17g');
