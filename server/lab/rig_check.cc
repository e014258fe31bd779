#include "server/lab/rig_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <sstream>
#include <tuple>
#include <utility>
#include <vector>

#include "core/diagnosis/diagnosis_options.h"
#include "core/estimators/estimator_bank.h"
#include "core/plant/simulate_record.h"
#include "core/signals/excitation.h"
#include "core/types/check.h"
#include "hardware/played_run.h"

namespace faultlab::server::lab {
namespace {

struct Tolerance {
  double gain;  ///< relative, of b0d and gain
  double pole;  ///< of a1d
};
constexpr Tolerance kHealthy{0.10, 0.12};  ///< a healthy bench stays inside
/// A band may be commissioned inside; the smallest relay step, R1 of the paper's bench to 10 ohm,
/// is outside.
constexpr Tolerance kCommissioned{0.30, 0.20};
/// The rig of a calibration is found again inside.
constexpr Tolerance kSameRig{0.05, 0.06};
/// Where friction makes more of the estimate than the tolerance: so many standard deviations.
constexpr double kSpreads = 4.0;
/// Coulomb friction of the simulated rigs, in standard deviations of the norm's: the middles of
/// eight equally probable parts of the normal distribution.
constexpr std::array<double, 8> kFrictions = {-1.53, -0.89, -0.49, -0.16, 0.16, 0.49, 0.89, 1.53};

constexpr double kCheckSecondsMin = 3.0;
constexpr int kCheckSamplesMin = 300;

RigVerdict Failed(std::string text) {
  return {false, std::move(text), std::nullopt};
}

RigVerdict FailedAt(RigVerdict verdict, CheckStep step) {
  verdict.passed = false;
  verdict.text = step.text;
  verdict.steps.push_back(std::move(step));
  return verdict;
}

std::string PositionText(const hardware::SelfTestPosition& position) {
  std::ostringstream text;
  text << core::Name(position.component) << " = " << position.value << ", " << position.line;
  return text.str();
}

/// The three quantities against the tolerances about `centre`. NaN is outside.
std::vector<CheckStep> Compare(const RigBand& found,
                               const RigBand& centre,
                               const RigBand& spread,
                               const Tolerance& tolerance) {
  std::vector<CheckStep> steps;
  const auto gain = [&](const char* name, double RigBand::*quantity) {
    const double share = std::max(tolerance.gain, kSpreads * spread.*quantity);
    const double middle = centre.*quantity;
    const double ratio = found.*quantity / middle;
    CheckStep step{.step = name};
    step.passed = std::abs(ratio - 1.0) <= share;
    const double reach = share * std::abs(middle);
    step.figure = {found.*quantity, middle - reach, middle + reach, "1/V"};
    if (!step.passed) {
      step.text = std::string(name) + " is " + std::to_string(ratio) + " of its norm";
    }
    steps.push_back(std::move(step));
  };
  gain("b0d", &RigBand::b0d);
  gain("gain", &RigBand::gain);
  CheckStep pole{.step = "a1d"};
  const double reach = std::max(tolerance.pole, kSpreads * spread.a1d);
  pole.passed = std::abs(found.a1d - centre.a1d) <= reach;
  pole.figure = {found.a1d, centre.a1d - reach, centre.a1d + reach, ""};
  if (!pole.passed) {
    pole.text = "a1d is " + std::to_string(found.a1d) + ", its norm " + std::to_string(centre.a1d);
  }
  steps.push_back(std::move(pole));
  return steps;
}

/// Why the first failed step failed; empty when all passed.
std::string FirstFailure(const std::vector<CheckStep>& steps) {
  for (const CheckStep& step : steps) {
    if (!step.passed) return step.text;
  }
  return {};
}

/// Of the newest window that excites.
core::Result<RigBand> EstimateOf(std::span<const core::Sample> samples,
                                 const core::Bench& bench,
                                 double delta_s) {
  core::EstimatorBankOptions options = core::BankOptions(core::OptionsOf(bench));
  options.delta_s = delta_s;
  core::EstimatorBank bank(options);
  std::array<core::Estimate<3>, core::kEstimatorCount> estimates{};
  const core::Estimate<3>& swa = estimates[static_cast<std::size_t>(core::EstimatorId::kSwa200)];
  std::optional<RigBand> band;
  for (const core::Sample& sample : samples) {
    bank.Push(sample, estimates);
    const bool usable =
        swa.status == core::EstimateStatus::kExcited || swa.status == core::EstimateStatus::kWeak;
    if (!usable || swa.age_samples != 0) continue;
    const auto& [b0d, b1d, a1d] = swa.theta;
    band = RigBand{b0d, (b0d + b1d) / (1.0 + a1d), a1d};
  }
  if (band) return *band;
  return core::Error{core::ErrorCode::kInvalid,
                     "the check's record gives no estimate: " + std::string(Name(swa.status)),
                     "",
                     "check_no_estimate"};
}

/// Mean and standard deviation over `bands` of one quantity.
std::pair<double, double> Moments(const std::vector<RigBand>& bands, double RigBand::*quantity) {
  const auto n = static_cast<double>(bands.size());
  double mean = 0.0;
  for (const RigBand& band : bands) mean += band.*quantity / n;
  double square = 0.0;
  for (const RigBand& band : bands) square += std::pow(band.*quantity - mean, 2) / (n - 1.0);
  return {mean, std::sqrt(square)};
}

/// The healthy rig that is simulated.
struct HealthyRig {
  core::PlantParameters parameters;
  double gain_factor = 1.0;  ///< of the amplifier
  double mc_nm = 0.0;        ///< Coulomb friction, expected
  double mc_sigma_nm = 0.0;
};

core::Result<RigNorm> SimulatedNorm(const core::Bench& bench,
                                    const HealthyRig& rig,
                                    double delta_s) {
  TRY(const auto uc_v, core::Generate(bench.excitation, CheckSeconds(bench), bench.period_s));
  LAB_CHECK(!bench.profiles.empty(), bench.name);
  core::BenchProfile profile = bench.profiles.front();
  profile.delta_s = delta_s;
  const double breakaway_nm = std::max(profile.friction.ms_nm - profile.friction.mc_nm, 0.0);
  std::vector<RigBand> bands;
  for (std::size_t i = 0; i < kFrictions.size(); ++i) {
    profile.friction.mc_nm = std::max(rig.mc_nm + kFrictions[i] * rig.mc_sigma_nm, 0.0);
    profile.friction.ms_nm = profile.friction.mc_nm + breakaway_nm;
    const std::vector<core::Sample> record =
        core::SimulateRecord(profile, rig.parameters, uc_v, {}, i + 1, bench.period_s);
    TRY(auto band, EstimateOf(record, bench, delta_s));
    band.b0d *= rig.gain_factor;
    band.gain *= rig.gain_factor;
    bands.push_back(band);
  }
  RigNorm norm;
  std::tie(norm.centre.b0d, norm.spread.b0d) = Moments(bands, &RigBand::b0d);
  std::tie(norm.centre.gain, norm.spread.gain) = Moments(bands, &RigBand::gain);
  std::tie(norm.centre.a1d, norm.spread.a1d) = Moments(bands, &RigBand::a1d);
  norm.spread.b0d /= std::abs(norm.centre.b0d);
  norm.spread.gain /= std::abs(norm.centre.gain);
  return norm;
}

/// What is expected is the limit on both sides: the change is compared as a whole, not this figure.
CheckStep StepOfContact(const hardware::ContactFinding& finding) {
  std::ostringstream subject;
  subject << core::Name(finding.component) << " = " << finding.value << ", " << finding.line;
  CheckStep step{.step = "contact",
                 .subject = subject.str(),
                 .passed = finding.contact != hardware::Contact::kWrong,
                 .text = finding.text};
  if (std::isfinite(finding.um_seen_v)) {
    step.figure = {finding.um_seen_v, finding.um_expected_v, finding.um_expected_v, "V"};
  } else if (std::isfinite(finding.ia_seen_a)) {
    step.figure = {finding.ia_seen_a, finding.ia_expected_a, finding.ia_expected_a, "A"};
  }
  return step;
}

}  // namespace

RigVerdict VerdictOf(const core::Error& error) {
  RigVerdict verdict = Failed(error.message);
  if (error.field != hardware::kLeaseField) {
    verdict.put_off = error.code == core::ErrorCode::kBusy && error.field.empty();
    return verdict;
  }
  if (error.code == core::ErrorCode::kStale) {
    verdict.text += ": this server's database is behind the rig, adopt the rig";
  } else {
    verdict.put_off = true;
  }
  return verdict;
}

double CheckSeconds(const core::Bench& bench) {
  return std::max(kCheckSecondsMin, kCheckSamplesMin * bench.period_s);
}

core::Result<RigNorm> NominalNorm(const core::Bench& bench, double delta_s) {
  // Every lease ends with a check, and the eight simulated ones cost more than judging it.
  static std::mutex mutex;
  static std::map<std::pair<std::string, double>, RigNorm> known;
  const std::pair key(bench.id, delta_s);
  {
    const std::lock_guard lock(mutex);
    if (const auto found = known.find(key); found != known.end()) return found->second;
  }
  const HealthyRig healthy{bench.nominal, 1.0, bench.norm.mc_nm, bench.norm.mc_sigma_nm};
  const core::Result<RigNorm> norm = SimulatedNorm(bench, healthy, delta_s);
  const std::lock_guard lock(mutex);
  if (norm) known.insert_or_assign(key, norm.value());
  return norm;
}

RigVerdict JudgeCheck(std::span<const core::Sample> samples,
                      const core::Bench& bench,
                      double delta_s,
                      const RigNorm& norm,
                      const std::optional<RigBand>& band) {
  const core::Result<RigBand> found = EstimateOf(samples, bench, delta_s);
  RigVerdict verdict;
  if (!found) return FailedAt(verdict, {.step = "record", .text = found.error().message});
  verdict.measured = found.value();
  verdict.steps = Compare(found.value(), band.value_or(norm.centre), norm.spread, kHealthy);
  verdict.text = FirstFailure(verdict.steps);
  verdict.passed = verdict.text.empty();
  return verdict;
}

bool IsOfCalibration(const RigBand& measured,
                     const core::Calibration& calibration,
                     const core::Bench& bench,
                     double delta_s) {
  const HealthyRig learnt{
      calibration.nominal, calibration.gain_factor, calibration.mc_nm, calibration.mc_sigma_nm};
  const core::Result<RigNorm> norm = SimulatedNorm(bench, learnt, delta_s);
  return norm && FirstFailure(Compare(measured, norm.value().centre, norm.value().spread, kSameRig))
                     .empty();
}

RigVerdict VerdictOf(const hardware::ContactReport& contacts) {
  std::string wrong = contacts.nominal;
  std::vector<CheckStep> steps;
  if (!contacts.nominal.empty()) steps.push_back({.step = "contact", .text = contacts.nominal});
  for (const hardware::ContactFinding& finding : contacts.positions) {
    steps.push_back(StepOfContact(finding));
    if (finding.contact != hardware::Contact::kWrong || !wrong.empty()) continue;
    wrong =
        std::string(core::Name(finding.component)) + " on " + finding.line + ": " + finding.text;
  }
  return {.passed = contacts.ok, .text = wrong, .steps = std::move(steps)};
}

core::Status CheckBand(const RigBand& measured, const RigNorm& norm) {
  const std::string outside =
      FirstFailure(Compare(measured, norm.centre, norm.spread, kCommissioned));
  if (outside.empty()) return core::Done{};
  return core::Error{core::ErrorCode::kInvalid,
                     "too far from the data sheet to be this rig's norm: " + outside,
                     "",
                     "too_far_from_data_sheet"};
}

RigVerdict CheckRig(hardware::Rig& rig, hardware::Epoch epoch, const std::optional<RigBand>& band) {
  RigVerdict so_far;
  if (const std::optional<hardware::Trip> held = rig.trip()) {
    return FailedAt(
        so_far,
        {.step = "interlock",
         .text = "the interlock " + held->name + " holds the rig: an operator must clear it"});
  }
  so_far.steps.push_back({.step = "interlock", .passed = true});
  const auto ended_by = [&so_far](const core::Error& error, const char* step) {
    const RigVerdict verdict = VerdictOf(error);
    RigVerdict out = FailedAt(so_far, {.step = step, .text = verdict.text});
    out.put_off = verdict.put_off;
    return out;
  };
  const core::Result<hardware::SelfTestReport> relays = rig.SelfTest(epoch);
  if (!relays) return ended_by(relays.error(), "relay");
  for (const hardware::SelfTestPosition& position : relays.value().positions) {
    CheckStep step{.step = "relay", .subject = PositionText(position), .passed = position.ok};
    if (!position.ok) step.text = "relay " + position.line + ": " + position.text;
    so_far.steps.push_back(std::move(step));
  }
  so_far.text = FirstFailure(so_far.steps);
  if (!so_far.text.empty()) return so_far;
  if (!relays.value().ok) {
    return FailedAt(so_far, {.step = "relay", .text = "the relays do not answer"});
  }
  const core::Bench& bench = *rig.description().bench;
  auto uc_v = core::Generate(bench.excitation, CheckSeconds(bench), bench.period_s);
  if (!uc_v) return ended_by(uc_v.error(), "record");
  hardware::RunPlan plan;
  plan.period_s = bench.period_s;
  plan.uc_v = std::move(uc_v).value();
  const core::Result<std::vector<core::Sample>> samples =
      hardware::PlayRun(rig, epoch, std::move(plan), "the check");
  if (!samples) return ended_by(samples.error(), "record");
  const double delta_s = rig.description().delta_s;
  const core::Result<RigNorm> norm = NominalNorm(bench, delta_s);
  if (!norm) return FailedAt(so_far, {.step = "norm", .text = norm.error().message});
  RigVerdict verdict = JudgeCheck(samples.value(), bench, delta_s, norm.value(), band);
  verdict.steps.insert(verdict.steps.begin(), so_far.steps.begin(), so_far.steps.end());
  return verdict;
}

}  // namespace faultlab::server::lab
