% A calibrator in Octave: the ellipsoid through the measurements, by algebraic least squares.
%
%   magbench calibrate log.csv --exec 'octave-ellipsoid=octave-cli -qf examples/ellipsoid.m {recording.csv} {result}'

words = argv();
strength_nT = str2double(getenv("MAGBENCH_FIELD_STRENGTH_NT"));
file = fopen(words{1}, "r");
names = strsplit(strtrim(fgetl(file)), ",");
columns = cellfun(@(name) find(strcmp(names, name)), {"mag_x_nT", "mag_y_nT", "mag_z_nT"});
table = textscan(file, repmat("%s", 1, numel(names)), "Delimiter", ",");  % text too: the phase is a word
fclose(file);
m = cell2mat(cellfun(@str2double, table(columns), "UniformOutput", false)) / strength_nT;
m = m(all(isfinite(m), 2), :);

[x, y, z] = deal(m(:, 1), m(:, 2), m(:, 3));
v = [x.^2, y.^2, z.^2, 2*x.*y, 2*x.*z, 2*y.*z, 2*x, 2*y, 2*z] \ ones(size(m, 1), 1);
A = [v(1), v(4), v(5); v(4), v(2), v(6); v(5), v(6), v(3)];
centre = -A \ v(7:9);
matrix = sqrtm(A / (1 + centre' * A * centre));

file = fopen(words{2}, "w");
fprintf(file, '{"offset_nT": [%.17g, %.17g, %.17g], ', strength_nT * centre);
fprintf(file, '"matrix": [[%.17g, %.17g, %.17g], [%.17g, %.17g, %.17g], [%.17g, %.17g, %.17g]]}', matrix');
fclose(file);
