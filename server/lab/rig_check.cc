#include "server/lab/rig_check.h"

#include <array>
#include <chrono>
#include <cmath>
#include <variant>
#include <vector>

#include "core/estimators/estimator_bank.h"
#include "core/plant/coefficients.h"
#include "core/signals/prbs.h"

namespace faultlab::server::lab {
namespace {

constexpr double kGainTolerance = 0.10;  ///< friction and tolerances of a healthy bench stay inside
/// Converter noise pulls the least squares' pole from -0.575 to about -0.51 on a healthy bench.
constexpr double kPoleTolerance = 0.12;
constexpr auto kPatience = std::chrono::milliseconds(200);
constexpr auto kLongest = std::chrono::seconds(30);

constexpr double kBandGainMax = 0.30;  ///< the smallest relay step, R1 to 10, moves b0d by more
constexpr double kBandPoleMax = 0.20;

RigVerdict Failed(std::string text) {
  return {false, std::move(text), std::nullopt};
}

/// What is not within the tolerances of `band`; empty when all is. NaN is outside.
std::string Outside(const RigBand& found, const RigBand& band, double gain_max, double pole_max) {
  const double direct = found.b0d / band.b0d;
  if (!(std::abs(direct - 1.0) <= gain_max)) {
    return "b0d is " + std::to_string(direct) + " of its norm";
  }
  const double ratio = found.gain / band.gain;
  if (!(std::abs(ratio - 1.0) <= gain_max)) {
    return "gain is " + std::to_string(ratio) + " of its norm";
  }
  if (!(std::abs(found.a1d - band.a1d) <= pole_max)) {
    return "a1d is " + std::to_string(found.a1d) + ", its norm " + std::to_string(band.a1d);
  }
  return {};
}

}  // namespace

RigVerdict VerdictOf(const core::Error& error) {
  RigVerdict verdict = Failed(error.message);
  if (error.field != hardware::kLeaseField) return verdict;
  if (error.code == core::ErrorCode::kStale) {
    verdict.text += ": this server's database is behind the rig, adopt the rig";
  } else {
    verdict.put_off = true;
  }
  return verdict;
}

RigBand NominalBand(double period_s, double delta_s) {
  const core::ContinuousCoefficients nominal = core::MakeContinuous(core::PlantParameters{});
  const core::DiscreteCoefficients wanted = core::Discretise(nominal, period_s, delta_s);
  return {wanted.b0d, nominal.b0, wanted.a1d};
}

RigVerdict JudgeCheck(std::span<const core::Sample> samples,
                      double period_s,
                      double delta_s,
                      const RigBand& band) {
  core::EstimatorBankOptions options;
  options.period_s = period_s;
  options.delta_s = delta_s;
  core::EstimatorBank bank(options);
  std::array<core::Estimate<3>, core::kEstimatorCount> estimates{};
  for (const core::Sample& sample : samples) bank.Push(sample, estimates);
  const core::Estimate<3>& swa = estimates[static_cast<std::size_t>(core::EstimatorId::kSwa200)];
  const bool usable =
      swa.status == core::EstimateStatus::kExcited || swa.status == core::EstimateStatus::kWeak;
  if (!usable || swa.age_samples != 0) {
    return Failed("the check's record gives no estimate: " + std::string(Name(swa.status)));
  }
  RigVerdict verdict;
  const RigBand found{
      swa.theta[0], (swa.theta[0] + swa.theta[1]) / (1.0 + swa.theta[2]), swa.theta[2]};
  verdict.measured = found;
  verdict.text = Outside(found, band, kGainTolerance, kPoleTolerance);
  verdict.passed = verdict.text.empty();
  return verdict;
}

core::Status CheckBand(const RigBand& measured, const RigBand& nominal) {
  const std::string outside = Outside(measured, nominal, kBandGainMax, kBandPoleMax);
  if (outside.empty()) return core::Done{};
  return core::Error{core::ErrorCode::kInvalid,
                     "too far from the data sheet to be this rig's norm: " + outside,
                     ""};
}

RigVerdict CheckRig(hardware::Rig& rig, hardware::Epoch epoch, const std::optional<RigBand>& band) {
  if (const std::optional<hardware::Trip> held = rig.trip()) {
    return Failed("the interlock " + held->name + " holds the rig: an operator must clear it");
  }
  const core::Result<hardware::SelfTestReport> relays = rig.SelfTest(epoch);
  if (!relays) return VerdictOf(relays.error());
  if (!relays.value().ok) {
    for (const auto& position : relays.value().positions) {
      if (!position.ok) return Failed("relay " + position.line + ": " + position.text);
    }
    return Failed("the relays do not answer");
  }
  hardware::RunPlan plan;
  plan.uc_v = core::MakePrbs({}, static_cast<int>(kCheckSeconds / plan.period_s), plan.period_s);
  const double period_s = plan.period_s;
  core::Status status = rig.Arm(std::move(plan), epoch);
  if (status.ok()) status = rig.Start(epoch);
  if (!status.ok()) return VerdictOf(status.error());
  std::vector<core::Sample> samples;
  std::vector<hardware::RigMessage> messages;
  std::string trip;
  const auto give_up = std::chrono::steady_clock::now() + kLongest;
  hardware::ReadStatus read = hardware::ReadStatus::kMore;
  while (read == hardware::ReadStatus::kMore) {
    if (std::chrono::steady_clock::now() > give_up) {
      rig.SafeStop("the check took too long");
      return Failed("the rig did not finish the check's plan");
    }
    messages.clear();
    read = rig.Read(messages, kPatience);
    for (const hardware::RigMessage& message : messages) {
      if (const auto* sample = std::get_if<core::Sample>(&message)) {
        samples.push_back(*sample);
      } else if (std::get<hardware::RigEvent>(message).kind == hardware::RigEventKind::kTrip) {
        trip = std::get<hardware::RigEvent>(message).text;
      }
    }
  }
  rig.SafeStop("the check has ended");
  if (!trip.empty()) return Failed("an interlock tripped: " + trip);
  const double delta_s = rig.description().delta_s;
  return JudgeCheck(samples, period_s, delta_s, band ? *band : NominalBand(period_s, delta_s));
}

}  // namespace faultlab::server::lab
