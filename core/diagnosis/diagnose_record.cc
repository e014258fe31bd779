#include "core/diagnosis/diagnose_record.h"

#include <algorithm>
#include <vector>

#include "core/diagnosis/pipeline.h"
#include "core/plant/model_fit.h"
#include "core/plant/sampled_model.h"

namespace faultlab::core {
namespace {

// The last part of a record over which the paper judges models.
constexpr std::size_t kFitSamples = 1000;

double FitOf(const Calibration& calibration,
             std::span<const Candidate> faults,
             std::span<const Sample> samples) {
  PlantParameters plant = calibration.nominal;
  for (const Candidate& fault : faults) plant.Set(fault.component, fault.value);
  // The plant's model knows no gain factor: R12 takes it.
  plant.r12_ohm = calibration.gain_factor * plant.re2_ohm() - plant.r14_ohm - plant.r15_ohm;
  std::vector<double> uc;
  std::vector<double> um;
  for (const Sample& sample : samples) {
    uc.push_back(sample.uc_v);
    um.push_back(sample.um_v);
  }
  return FitSampled(MakeSampledModel(plant, calibration.period_s, calibration.delta_s),
                    calibration.mc_nm,
                    uc,
                    um)
      .fit_percent;
}

}  // namespace

Diagnosis DiagnoseRecord(std::span<const Sample> samples, const DiagnosisOptions& options) {
  Pipeline pipeline(options);
  for (const Sample& sample : samples) {
    pipeline.Push(sample);
    while (std::optional<DiagnosisTask> task = pipeline.TakeTask()) pipeline.Accept(RunTask(*task));
  }
  Diagnosis diagnosis = pipeline.Finish();
  if (diagnosis.calibration && samples.size() > 1) {
    const auto tail = samples.last(std::min(kFitSamples, samples.size()));
    diagnosis.fit_percent.push_back({"nominal", FitOf(*diagnosis.calibration, {}, tail)});
    if (diagnosis.verdict.kind == VerdictKind::kFault && !diagnosis.verdict.candidates.empty()) {
      diagnosis.fit_percent.push_back(
          {"isolated",
           FitOf(*diagnosis.calibration,
                 std::span<const Candidate>(&diagnosis.verdict.candidates.front(), 1),
                 tail)});
    }
  }
  return diagnosis;
}

void ReplayEstimates(std::span<const Sample> samples,
                     const DiagnosisOptions& options,
                     const std::function<void(const Frame&)>& each) {
  EstimatorBank bank(BankOptions(options));
  Frame frame;
  for (const Sample& sample : samples) {
    frame.sample = sample;
    bank.Push(sample, frame.estimates);
    each(frame);
  }
}

}  // namespace faultlab::core
