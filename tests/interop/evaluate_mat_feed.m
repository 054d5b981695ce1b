% All numbers of an flc's or aflc's MAT file: octave-cli evaluate_mat_feed.m FILE OUTPUT
args = argv();
load(args{1});
terms = [controller.error_terms, controller.error_change_terms];
labels = controller.rules.labels;
assert(iscellstr(labels) && strcmp(labels{1, 1}, 'NL') && strcmp(terms(7).label, 'PL'));
assert(strcmp(units.row_input, 'error') && isequal(units.table, controller.rules.centroids));
assert(isempty(controller.low_velocity));
dlmwrite(args{2}, [[terms.left]; [terms.centre]; [terms.right]], 'precision', '%.17g');
