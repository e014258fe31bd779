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

RigVerdict Failed(std::string text) {
  return {false, std::move(text)};
}

}  // namespace

RigVerdict JudgeCheck(std::span<const core::Sample> samples, double period_s, double delta_s) {
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
  const core::ContinuousCoefficients nominal = core::MakeContinuous(core::PlantParameters{});
  const core::DiscreteCoefficients wanted = core::Discretise(nominal, period_s, delta_s);
  const double direct = swa.theta[0] / wanted.b0d;
  if (!(std::abs(direct - 1.0) <= kGainTolerance)) {
    return Failed("b0d is " + std::to_string(direct) + " of the nominal one");
  }
  const double gain = (swa.theta[0] + swa.theta[1]) / (1.0 + swa.theta[2]);
  const double ratio = gain / nominal.b0;
  if (!(std::abs(ratio - 1.0) <= kGainTolerance)) {
    return Failed("gain is " + std::to_string(ratio) + " of the nominal one");
  }
  if (!(std::abs(swa.theta[2] - wanted.a1d) <= kPoleTolerance)) {
    return Failed("a1d is " + std::to_string(swa.theta[2]) + ", nominal " +
                  std::to_string(wanted.a1d));
  }
  return {true, ""};
}

RigVerdict CheckRig(hardware::Rig& rig, hardware::Epoch epoch) {
  const hardware::SelfTestReport relays = rig.SelfTest();
  if (!relays.ok) {
    for (const auto& position : relays.positions) {
      if (!position.ok) return Failed("relay " + position.line + ": " + position.text);
    }
    return Failed("the relays do not answer");
  }
  hardware::RunPlan plan;
  plan.uc_v = core::MakePrbs({}, static_cast<int>(kCheckSeconds / plan.period_s), plan.period_s);
  const double period_s = plan.period_s;
  core::Status status = rig.Arm(std::move(plan), epoch);
  if (status.ok()) status = rig.Start(epoch);
  if (!status.ok()) return Failed(status.error().message);
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
  return JudgeCheck(samples, period_s, rig.description().delta_s);
}

}  // namespace faultlab::server::lab
