% Reads the MAT file that a run's page downloads and draws it, in MATLAB and Octave.
%   run = load_run('2026-11-21_0102_R1_samples-estimates.mat');
%   plot(run.t_s, run.um_v)
% Columns have one row for each sample; a lost reading is NaN. Estimators: swa_50, swa_100, swa_200
% with b0d b1d a1d, and sia_20_5, sia_100_20, sia_500_20 with b0 b1 a1. Status: 0 excited, 1 weak,
% 2 not excited, 3 invalid.
function run = load_run(path)
  run = load(path);
  usable = run.sia_100_20_status <= 1;
  estimates = run.sia_100_20;
  estimates(~usable, :) = NaN;
  subplot(2, 1, 1);
  plot(run.t_s, run.uc_v, run.t_s, run.um_v);
  legend('uc', 'um');
  ylabel('V');
  title(run.name, 'Interpreter', 'none');
  subplot(2, 1, 2);
  plot(run.t_s, estimates);
  legend('b0', 'b1', 'a1');
  xlabel('t, s');
end
