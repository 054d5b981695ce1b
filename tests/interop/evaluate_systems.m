% Outputs of many .fis: octave-cli evaluate_systems.m COUNT FOLDER OUTPUTS
% FOLDER has N.fis and N.points; a row of OUTPUTS is a file's, NaN where evalfis has none.
pkg load fuzzy-logic-toolkit
args = argv();
function place = level_mom(x, y) % mom of which no last bit decides
  place = mean(x(y >= (1 - 1e-14) * max(y) & y > 0));
endfunction
warning('off', 'all');
rows = [];
for n = 0:str2double(args{1}) - 1
  fis = readfis(fullfile(args{2}, sprintf('%d.fis', n)));
  points = load('-ascii', fullfile(args{2}, sprintf('%d.points', n)));
  row = NaN(1, size(points, 1));
  for k = 1:size(points, 1)
    try
      row(k) = evalfis(points(k, :), fis);
    catch
    end
  end
  rows(end + 1, :) = row;
end
dlmwrite(args{3}, rows, 'precision', '%.17g');
