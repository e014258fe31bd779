#include "core/diagnosis/diagnose_record.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/calibration/step_response.h"
#include "core/diagnosis/pipeline.h"
#include "core/plant/measured_gain.h"
#include "core/plant/model_fit.h"
#include "core/plant/sampled_model.h"

namespace faultlab::core {
namespace {

// The paper compares models over this time at the end of a record.
constexpr double kFitSeconds = 10.0;

double FitOf(const Calibration& calibration,
             const Bench& bench,
             std::span<const Candidate> faults,
             std::span<const Sample> samples) {
  PlantParameters plant = WithMeasuredLag(calibration.nominal, calibration.lag_factor);
  for (const Candidate& fault : faults) plant.Set(fault.component, fault.value);
  plant = WithMeasuredGain(plant, calibration.gain_factor);
  const EstimatedChannel channel = plant.structure->estimated;
  std::vector<double> uc;
  std::vector<double> y;
  double before_v = samples.empty() ? 0.0 : samples.front().uc_v;
  for (const Sample& sample : samples) {
    const double row_before_v = std::exchange(before_v, sample.uc_v);
    uc.push_back(bench.follows_row_before() ? row_before_v : sample.uc_v);
    y.push_back(ReadingOf(sample, channel) / ReadingPerOutput(plant));
  }
  return FitSampled(MakeSampledModel(plant, calibration.period_s, calibration.delta_s),
                    InfoOf(channel).row,
                    calibration.mc_nm,
                    uc,
                    y)
      .fit_percent;
}

// What is not the rig of the calibration from the beginning on is perhaps no fault of the rig.
constexpr double kBeginningS = 1.0;
// Before most faults of a record begin.
constexpr double kHealthyS = 5.0;

void NameWhatIsWrong(std::span<const Sample> samples,
                     const DiagnosisOptions& options,
                     Diagnosis& diagnosis) {
  Verdict& verdict = diagnosis.verdict;
  if (!options.calibration || verdict.kind != VerdictKind::kUnknownFault) return;
  if (IsOutside(verdict)) return;
  const double from_s = std::max(samples.front().t_s, options.healthy_from_s);
  if (verdict.detected_at_s.value_or(from_s) > from_s + kBeginningS) return;
  const auto end = std::find_if(samples.begin(), samples.end(), [&](const Sample& sample) {
    return sample.t_s > from_s + kHealthyS;
  });
  const auto stretch = samples.first(static_cast<std::size_t>(end - samples.begin()));
  if (const std::optional<std::string> wrong = WhatIsWrong(stretch, CalibrationOf(options))) {
    verdict.reason = "the record is not of the calibrated rig from its beginning on; " + *wrong;
    if (!diagnosis.episodes.empty()) diagnosis.episodes.back().verdict.reason = verdict.reason;
  }
}

/// A record of a step or two teaches no rig, but tells how its motor answers.
void TellStepResponse(std::span<const Sample> samples,
                      const DiagnosisOptions& options,
                      Diagnosis& diagnosis) {
  if (!diagnosis.calibration_refusal) return;
  const std::string& check = diagnosis.calibration_refusal->field;
  if (check != "excitation" && check != "length") return;
  if (const auto text = StepResponseText(samples, *options.bench, options.period_s)) {
    diagnosis.verdict.reason += "; " + *text;
  }
}

}  // namespace

Diagnosis DiagnoseRecord(
    std::span<const Sample> samples,
    const DiagnosisOptions& options,
    const std::function<void(const Verdict& verdict, std::int64_t index)>& told) {
  Pipeline pipeline(options);
  std::uint64_t seen = pipeline.verdict_version();
  for (const Sample& sample : samples) {
    pipeline.Push(sample);
    while (std::optional<DiagnosisTask> task = pipeline.TakeTask()) pipeline.Accept(RunTask(*task));
    const std::uint64_t newest = pipeline.verdict_version();
    if (told && newest != std::exchange(seen, newest)) told(pipeline.verdict(), sample.index);
  }
  Diagnosis diagnosis = pipeline.Finish();
  if (told && !samples.empty()) told(diagnosis.verdict, samples.back().index);
  if (diagnosis.calibration && samples.size() > 1 &&
      diagnosis.calibration->Uses(options.bench->structure->estimated)) {
    const auto fitted = static_cast<std::size_t>(std::lround(kFitSeconds / options.period_s));
    const auto tail = samples.last(std::min(fitted, samples.size()));
    diagnosis.fit_percent.push_back(
        {"nominal", FitOf(*diagnosis.calibration, *options.bench, {}, tail)});
    if (diagnosis.verdict.kind == VerdictKind::kFault && !diagnosis.verdict.candidates.empty()) {
      diagnosis.fit_percent.push_back(
          {"isolated",
           FitOf(*diagnosis.calibration,
                 *options.bench,
                 std::span<const Candidate>(&diagnosis.verdict.candidates.front(), 1),
                 tail)});
    }
  }
  if (!samples.empty()) NameWhatIsWrong(samples, options, diagnosis);
  TellStepResponse(samples, options, diagnosis);
  return diagnosis;
}

namespace {

/// A bench without a channel of this one fits whatever is wrong with that.
bool ReadsLess(const Bench& bench, const Bench& than) {
  const Converters& its = bench.profiles.front().converters;
  const Converters& ours = than.profiles.front().converters;
  return (ours.has_um && !its.has_um) || (ours.has_ia && !its.has_ia) || (ours.has_n && !its.has_n);
}

}  // namespace

void SuggestBench(std::span<const Sample> samples,
                  const DiagnosisOptions& options,
                  std::span<const Bench* const> others,
                  Diagnosis& diagnosis) {
  constexpr std::size_t kTriedMax = 10;
  constexpr std::array<std::string_view, 4> kDoesNotFit = {
      "noise", "friction", "tolerance", "stationarity"};
  if (!diagnosis.calibration_refusal ||
      std::ranges::find(kDoesNotFit, diagnosis.calibration_refusal->field) == kDoesNotFit.end() ||
      diagnosis.verdict.reason.find("; it fits ") != std::string::npos ||
      diagnosis.verdict.reason.find("; its first ") != std::string::npos ||
      diagnosis.verdict.reason.find(" smoothed: ") != std::string::npos) {
    return;
  }
  std::vector<Sample> stretch;
  std::ranges::copy_if(samples, std::back_inserter(stretch), [&](const Sample& sample) {
    return sample.t_s >= options.healthy_from_s && sample.t_s < options.healthy_to_s;
  });
  std::size_t tried = 0;
  for (const Bench* bench : others) {
    if (bench->id == options.bench->id || ReadsLess(*bench, *options.bench)) continue;
    if (++tried > kTriedMax) return;
    const DiagnosisOptions there = OptionsOf(*bench, options.period_s);
    if (!Fits(stretch, CalibrationOf(there))) continue;
    diagnosis.verdict.reason += "; it fits the bench " + bench->name + ": was it measured there?";
    return;
  }
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
