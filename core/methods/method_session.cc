#include "core/methods/method_session.h"

#include <cmath>
#include <string>

#include "core/calibration/calibrate.h"
#include "core/diagnosis/diagnosis_options.h"
#include "core/types/number_text.h"

namespace faultlab::core {
namespace {

ObservationBuilder BuilderOf(const MethodTask& task) {
  const DiagnosisOptions options = OptionsOf(*task.bench, task.period_s);
  return {task.bench->readings(),
          task.channels,
          task.period_s,
          options.um_rail_v,
          ErrorsOf(task.calibration)};
}

std::string Number(double value) {
  return Format("%.3g", value);
}

}  // namespace

MethodOptions MethodOptionsOf(const Bench& bench, double period_s) {
  const DiagnosisOptions usual = OptionsOf(bench, period_s);
  MethodOptions options;
  options.bench = &bench;
  options.period_s = period_s;
  options.healthy_from_s = usual.healthy_from_s;
  options.healthy_to_s = usual.healthy_to_s;
  if (bench.structure->estimated != EstimatedChannel::kUm) options.channels = Channels::kAll;
  return options;
}

Result<MethodTask> PrepareMethods(std::span<const Sample> samples, const MethodOptions& options) {
  std::vector<Sample> healthy;
  for (const Sample& sample : samples) {
    if (sample.t_s >= options.healthy_from_s && sample.t_s < options.healthy_to_s) {
      healthy.push_back(sample);
    }
  }
  if (samples.empty() || samples.back().t_s < options.healthy_to_s) {
    const std::string until_s = Number(options.healthy_to_s);
    return Refuse("nothing_left", "healthy_to_s", {{"until_s", until_s}});
  }
  CalibrationOptions calibrate;
  calibrate.bench = options.bench;
  calibrate.data_sheet = options.bench->nominal;
  calibrate.channels = options.channels;
  calibrate.period_s = options.period_s;
  calibrate.um_rail_v = OptionsOf(*options.bench, options.period_s).um_rail_v;
  TRY(auto calibration, Calibrate(healthy, calibrate));
  MethodTask task;
  task.bench = options.bench;
  task.calibration = WithHumAsNoise(calibration);
  task.healthy = MakeObservations(healthy,
                                  options.bench->readings(),
                                  options.channels,
                                  options.period_s,
                                  calibrate.um_rail_v,
                                  ErrorsOf(task.calibration));
  task.channels = options.channels;
  task.period_s = options.period_s;
  task.seed = options.seed;
  return task;
}

MethodSession::MethodSession(const MethodInfo& info, MethodTask task, double tuning, double level)
    : builder_(BuilderOf(task)), level_(level) {
  task.tuning = tuning;
  method_ = info.make(task);
}

bool MethodSession::Push(const Sample& sample) {
  Observation observation;
  if (!builder_.Push(sample, observation)) return false;
  method_->Push(sample, observation);
  if (alarmed() || !(method_->statistic() > level_)) return false;
  alarmed_at_s_ = sample.t_s;
  method_->OnAlarm();
  return true;
}

MethodRun RunMethod(const MethodInfo& info,
                    const MethodTask& task,
                    std::span<const Sample> samples,
                    double from_s) {
  MethodRun run;
  run.method = info.name;
  MethodSession session(info, task);
  std::size_t next = 0;
  for (const Sample& sample : samples) {
    if (sample.t_s < from_s) continue;
    session.Push(sample);
    if (!session.alarmed() || next >= kLookAfterS.size()) continue;
    if (sample.t_s + 0.5 * task.period_s < *session.alarmed_at_s() + kLookAfterS[next]) continue;
    run.looks.push_back({kLookAfterS[next], session.Diagnose()});
    ++next;
  }
  run.alarmed_at_s = session.alarmed_at_s();
  if (session.alarmed()) {
    run.looks.push_back({samples.back().t_s - *run.alarmed_at_s, session.Diagnose()});
  }
  return run;
}

}  // namespace faultlab::core
