#include "core/calibration/clean_stretch.h"

#include <array>
#include <bit>
#include <cstdio>
#include <utility>

#include "core/filter/find_hum.h"
#include "core/filter/hum_tracker.h"
#include "core/filter/impulses.h"
#include "core/filter/prediction_model.h"
#include "core/types/number_text.h"

namespace faultlab::core {
namespace {

// The second time by the rig that the first has shown.
constexpr int kHumRounds = 2;
// Readings that stand alone are looked for again once the fit is rid of the first.
constexpr int kImpulseRounds = 3;
constexpr double kFirstGate = 8.0;

double ShareOfReadings(std::size_t impulses, std::span<const Observation> stretch) {
  int readings = 0;
  for (const Observation& o : stretch) readings += std::popcount(o.mask);
  const double all = static_cast<double>(impulses) + readings;
  return all > 0.0 ? static_cast<double>(impulses) / all : 0.0;
}

/// Whether readings that were left out follow each other: every third one, or so many in a row that
/// the detector would not take them for impulses. Then they are signal that the model lacks.
bool ComeInRows(std::span<const Observation> with, std::span<const Observation> without) {
  constexpr int kFollowMin = 3;
  int odd = 0;
  int follow = 0;
  bool before = false;
  bool passed = false;
  RowOfOddSamples row;
  for (std::size_t k = 0; k < with.size(); ++k) {
    const bool now = with[k].mask != without[k].mask;
    odd += now;
    follow += now && before;
    before = now;
    row.Push(now);
    passed = passed || row.passed();
  }
  return passed || (follow >= kFollowMin && 3 * follow > odd);
}

void SayImpulses(std::size_t impulses, double share, std::vector<CalibrationCheck>& checks) {
  if (impulses == 0) return;
  const std::string text =
      Format("%zu readings stand alone, far from their neighbours (%.2g %%), and are left out",
             impulses,
             100.0 * share);
  checks.push_back({"impulses", text, share, 0.05, true});
}

void SayHum(const Hum& hum, const Calibration& calibration, std::vector<CalibrationCheck>& checks) {
  if (!hum.any()) return;
  std::array<char, 120> text{};
  const double um_mv = 1e3 * hum.um.amplitude();
  const double ia_ma = 1e3 * hum.ia.amplitude();
  if (calibration.used_um && calibration.used_ia) {
    std::snprintf(text.data(),
                  text.size(),
                  "hum of %.2f Hz, %.1f mV of um and %.1f mA of ia, is taken out",
                  hum.frequency_hz,
                  um_mv,
                  ia_ma);
  } else {
    std::snprintf(text.data(),
                  text.size(),
                  "hum of %.2f Hz, %.1f %s, is taken out",
                  hum.frequency_hz,
                  calibration.used_um ? um_mv : ia_ma,
                  calibration.used_um ? "mV of um" : "mA of ia");
  }
  checks.push_back({"hum", text.data(), hum.frequency_hz, 0.0, true});
}

std::vector<Sample> WithoutHum(std::span<const Sample> samples, const Hum& hum) {
  std::vector<Sample> clean;
  clean.reserve(samples.size());
  for (const Sample& sample : samples) clean.push_back(WithoutHum(sample, hum));
  return clean;
}

}  // namespace

Readings ReadingsOf(std::span<const Sample> samples, const CalibrationOptions& options) {
  Readings readings;
  readings.observations = MakeObservations(samples,
                                           options.bench->readings(),
                                           options.channels,
                                           options.period_s,
                                           options.um_rail_v,
                                           {},
                                           &readings.t_s);
  return readings;
}

CleanStretch::CleanStretch(std::span<const Sample> samples,
                           const CalibrationOptions& options,
                           unsigned mask,
                           const RigParameters& data_sheet,
                           GaussianPrior prior,
                           std::optional<double> expected_delta_s)
    : samples_(samples),
      options_(options),
      data_sheet_(data_sheet),
      prior_(std::move(prior)),
      expected_delta_s_(expected_delta_s),
      readings_(ReadingsOf(samples, options)),
      with_impulses_(readings_.observations),
      stretch_{options.bench, options.period_s, readings_.observations, mask, {}} {
  Explain();
}

void CleanStretch::TakeOut() {
  TakeOutHum();
  LeaveOutImpulses();
  if (impulses_ == 0 || hum_.any()) return;
  // A few impulses may have hidden it.
  TakeOutHum();
  if (hum_.any()) LeaveOutImpulses();
}

void CleanStretch::Tell(Calibration& calibration) const {
  calibration.hum = hum_;
  SayHum(hum_, calibration, calibration.checks);
  calibration.impulse_share = ShareOfReadings(impulses_, stretch_.samples);
  SayImpulses(impulses_, calibration.impulse_share, calibration.checks);
}

void CleanStretch::Explain() {
  explained_ = ExplainStretch(stretch_, data_sheet_, prior_, expected_delta_s_);
}

PredictionModel CleanStretch::Model() const {
  return MakePredictionModel(
      RigAt(stretch_, explained_.base, explained_.fit.point), explained_.noise, options_.period_s);
}

void CleanStretch::TakeOutHum() {
  const Readings with_hum = readings_;
  for (int round = 0; round < kHumRounds; ++round) {
    const Hum hum = FindHum(Model(), with_hum.observations, with_hum.t_s, options_.period_s);
    if (!hum.any()) break;
    hum_ = hum;
    readings_ = ReadingsOf(WithoutHum(samples_, hum), options_);
    stretch_.samples = readings_.observations;
    Explain();
  }
  if (hum_.any()) with_impulses_ = readings_.observations;
}

void CleanStretch::LeaveOutImpulses() {
  impulses_ = 0;
  for (int round = 0; round < kImpulseRounds; ++round) {
    // The first must be so far off that no model error is behind them; then nearer ones go too.
    const ImpulseRule rule{.gate = round == 0 ? kFirstGate : kImpulseGate};
    const std::size_t more = core::LeaveOutImpulses(Model(), readings_.observations, rule);
    if (more == 0) break;
    if (ComeInRows(with_impulses_, readings_.observations)) {
      readings_.observations = with_impulses_;
      stretch_.samples = readings_.observations;
      if (impulses_ > 0) Explain();
      impulses_ = 0;
      return;
    }
    impulses_ += more;
    Explain();
  }
}

}  // namespace faultlab::core
