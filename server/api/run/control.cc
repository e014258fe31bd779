// How well a run under speed control kept its reference.
#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <limits>
#include <span>

#include "core/control/closed_loop/control_replay.h"
#include "core/control/control_quality.h"
#include "server/api/run/handlers.h"
#include "server/experiment/control_json.h"
#include "server/experiment/plan_json.h"
#include "server/experiment/rig_changes.h"
#include "server/run/run_messages.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using hardware::RigEvent;
using hardware::RigEventKind;

// A run without a fault is judged from here on after the control began.
constexpr double kRunInS = 4.5;

/// Of one run, in its own units: samples by index, speeds of the motor shaft.
struct ControlAccount {
  const Review& review;
  PlannedControl planned;
  std::size_t size = 0;  ///< samples, those that are missing included
  std::size_t reference_from = 0;
  std::optional<std::size_t> began{};
  std::size_t judged_from = 0;
  std::vector<double> reference_rad_s{};
  double rad_per_s = 1.0;  ///< of 1 rpm of n
};

double Rounded(double n_rpm) {
  constexpr double kSteps = 100.0;
  return std::round(n_rpm * kSteps) / kSteps;
}

std::vector<RigEvent> EventsOf(const Review& review) {
  std::vector<RigEvent> out;
  for (const RecordedEvent& each : review.events) {
    if (auto event = ToRigEvent(each, *review.recording.options.bench)) {
      out.push_back(*std::move(event));
    }
  }
  return out;
}

ControlAccount AccountOf(const Review& review,
                         PlannedControl planned,
                         std::span<const RigEvent> events) {
  const core::DiagnosisOptions& options = review.recording.options;
  const std::vector<core::Sample>& samples = review.recording.samples;
  const double period_s = options.period_s;
  ControlAccount account{.review = review, .planned = std::move(planned)};
  account.rad_per_s = core::RadPerSecondOfRpm(options.bench->nominal.gear_ratio);
  account.size = samples.empty() ? 0 : static_cast<std::size_t>(samples.back().index + 1);
  const auto sample_at = [&](double t_s) {
    return static_cast<std::size_t>(std::lround(std::max(t_s, 0.0) / period_s));
  };
  account.reference_from = sample_at(account.planned.from_s);
  const auto began = std::ranges::find(events, RigEventKind::kControlBegan, &RigEvent::kind);
  if (began != events.end()) account.began = static_cast<std::size_t>(began->index);
  const core::ReferencePlayer player(account.planned.wanted.reference, period_s);
  account.reference_rad_s.assign(account.size, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = account.reference_from; k < account.size; ++k) {
    account.reference_rad_s[k] = player.At(k - account.reference_from);
  }
  const std::vector<RigChange> changes = ChangesOf(review.events, *options.bench, period_s);
  const double from_s = changes.empty() ? account.planned.from_s + kRunInS : changes.front().t_s;
  account.judged_from =
      std::max({sample_at(from_s), account.reference_from, account.began.value_or(0)});
  return account;
}

json::value QualityToJson(const ControlAccount& account, std::span<const core::Sample> samples) {
  if (!account.began || account.judged_from >= account.size) return nullptr;
  std::vector<double> speed_rad_s(account.size, std::numeric_limits<double>::quiet_NaN());
  for (const core::Sample& sample : samples) {
    const auto index = static_cast<std::size_t>(sample.index);
    if (index < speed_rad_s.size()) speed_rad_s[index] = sample.n_rpm * account.rad_per_s;
  }
  const double period_s = account.review.recording.options.period_s;
  const core::ControlQuality quality = core::QualityOf(account.planned.wanted.reference,
                                                       {.reference_rad_s = account.reference_rad_s,
                                                        .speed_rad_s = speed_rad_s,
                                                        .control_from = account.reference_from,
                                                        .from = account.judged_from,
                                                        .period_s = period_s});
  return json::object{
      {"from_s", static_cast<double>(account.judged_from) * period_s},
      {"iae_rad", quality.iae_rad},
      {"late_iae_rad", quality.late_iae_rad},
      {"overshoot_percent", quality.overshoot_percent},
      {"settling_s", quality.settling_s ? json::value(*quality.settling_s) : json::value(nullptr)},
      {"steady_error_rad_s", quality.steady_error_rad_s}};
}

/// The corners of the reference from its beginning to the end of the plan.
json::object ReferenceToJson(const ControlAccount& account) {
  const double period_s = account.review.recording.options.period_s;
  const core::SpeedReference& reference = account.planned.wanted.reference;
  const core::ReferencePlayer player(reference, period_s);
  const auto end = static_cast<std::size_t>(
      std::lround(SecondsOfPlan(account.review.recording.record.plan_json) / period_s));
  const bool ramp = reference.shape == core::SpeedReference::Shape::kRamp;
  json::array t_s;
  json::array n_rpm;
  const auto corner = [&](std::size_t sample, std::size_t tick) {
    t_s.push_back(static_cast<double>(sample) * period_s);
    n_rpm.push_back(Rounded(player.At(tick) / account.rad_per_s));
  };
  const std::size_t hold = player.hold_ticks();
  for (std::size_t k = account.reference_from; k < end; k += hold) {
    const std::size_t tick = k - account.reference_from;
    const std::size_t next = std::min(k + hold, end);
    corner(k, tick);
    corner(next, ramp ? tick + (next - k) : tick);
  }
  return {{"t_s", std::move(t_s)}, {"n_rpm", std::move(n_rpm)}};
}

json::array CompensationsToJson(const ControlAccount& account, std::span<const RigEvent> events) {
  const double period_s = account.review.recording.options.period_s;
  json::array out;
  const auto ends = [&](const RigEvent& event, const json::value& why) {
    if (out.empty() || !out.back().at("until_s").is_null()) return;
    out.back().as_object()["until_s"] = static_cast<double>(event.index) * period_s;
    out.back().as_object()["ended"] = why;
  };
  for (const RigEvent& event : events) {
    if (event.kind == RigEventKind::kCompensationEnded) ends(event, json::value(event.text));
    if (event.kind != RigEventKind::kCompensated) continue;
    ends(event, nullptr);
    out.push_back(json::object{{"t_s", static_cast<double>(event.index) * period_s},
                               {"component", core::Name(event.component)},
                               {"value", event.value},
                               {"until_s", nullptr},
                               {"ended", nullptr}});
  }
  return out;
}

/// The run once more on its simulator, without a diagnosis; null where that cannot be.
json::value WithoutToJson(const ControlAccount& account) {
  const Recording& recording = account.review.recording;
  const core::Bench& bench = *recording.options.bench;
  const core::BenchProfile* profile = bench.FindProfile(account.planned.profile);
  const auto& calibration = account.review.diagnosis.calibration;
  const bool whole = account.size == recording.samples.size();
  if (profile == nullptr || !calibration || !account.began || !whole ||
      *account.began < account.reference_from || *account.began == 0 ||
      HidesFaults(recording.record.plan_json)) {
    return nullptr;
  }
  core::ControlledRecord record;
  record.bench = &bench;
  record.profile = profile;
  std::vector<double> uc_v;
  for (const core::Sample& sample : recording.samples) uc_v.push_back(sample.uc_v);
  record.uc_v = uc_v;
  record.began = *account.began;
  record.reference_from = account.reference_from;
  record.reference = account.planned.wanted.reference;
  record.faults = FaultsToShow(ChangesOf(account.review.events, bench, recording.record.period_s),
                               FaultsOfPlan(recording.record.plan_json, bench));
  record.calibration = *calibration;
  record.period_s = recording.options.period_s;
  record.seed = SeedOfPlan(recording.record.plan_json).value_or(1);
  const std::vector<core::Sample> without = core::WithoutCompensation(record);
  json::array n_rpm;
  for (std::size_t k = record.began; k < without.size(); ++k) {
    const double n = without[k].n_rpm;
    n_rpm.push_back(std::isfinite(n) ? json::value(Rounded(n)) : json::value(nullptr));
  }
  return json::object{{"from_s", static_cast<double>(record.began) * record.period_s},
                      {"n_rpm", std::move(n_rpm)},
                      {"quality", QualityToJson(account, without)}};
}

}  // namespace

core::Result<HttpResponse> GetControl(RunApi& api, const ApiRequest& request) {
  const core::Status known = OnlyQuery(request.http, {"without"});
  if (!known.ok()) return known.error();
  const auto without = QueryWord(request.http, "without", {"include"});
  if (!without) return without.error();
  const auto options = api.recordings.OptionsFor(request.run);
  if (!options) return options.error();
  auto planned = ControlOfPlan(request.run.plan_json, *options.value().bench, request.run.period_s);
  if (!planned) {
    return core::Error{core::ErrorCode::kNotFound,
                       "This run was played without speed control.",
                       "",
                       "run_without_control"};
  }
  const auto review = api.recordings.ReviewOf(request.run);
  if (!review) return review.error();
  const std::vector<RigEvent> events = EventsOf(review.value());
  const ControlAccount account = AccountOf(review.value(), *std::move(planned), events);
  const double period_s = review.value().recording.options.period_s;
  json::object out{{"from_s", account.planned.from_s},
                   {"began_s", nullptr},
                   {"controller", core::Name(account.planned.wanted.options.kind)},
                   {"reference", ReferenceToJson(account)},
                   {"compensations", CompensationsToJson(account, events)},
                   {"quality", QualityToJson(account, review.value().recording.samples)},
                   {"without", nullptr}};
  if (account.began) out["began_s"] = static_cast<double>(*account.began) * period_s;
  const bool ended = request.run.state != RunState::kRunning;
  if (without.value() && ended) out["without"] = WithoutToJson(account);
  return JsonResponse(out);
}

}  // namespace faultlab::server
