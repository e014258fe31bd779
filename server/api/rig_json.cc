#include "server/api/rig_json.h"

#include <boost/json.hpp>
#include <chrono>

#include "server/api/iso8601.h"
#include "server/json/number_or_null.h"
#include "server/run/loop_json.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

std::string TextFor(RigReader who, const hardware::Trip& trip) {
  if (who == RigReader::kOperator) return trip.text;
  return "the interlock holds the rig: an operator must clear it";
}

json::value TripToJson(RigReader who, const std::optional<hardware::Trip>& trip) {
  if (!trip) return nullptr;
  const auto seen = [who](auto number) -> json::value {
    return who == RigReader::kOperator ? json::value(number) : json::value(nullptr);
  };
  return json::object{{"name", trip->name},
                      {"value", seen(trip->value)},
                      {"limit", trip->limit},
                      {"index", seen(trip->index)},
                      {"t_s", seen(trip->t_s)},
                      {"text", TextFor(who, *trip)}};
}

json::object AmplifierToJson(const hardware::RigDescription& about) {
  const bool current = about.bench != nullptr && about.bench->structure->drives_current();
  const bool four = about.amplifier_quadrants == core::Quadrants::kFour;
  return {{"mode", current ? "current" : "voltage"}, {"quadrants", four ? 4 : 2}};
}

json::object LinkToJson(const hardware::RemoteRigInfo& remote) {
  const auto seen = remote.epoch;
  const auto refusal = remote.refusal;
  return {{"state", hardware::Name(remote.link)},
          {"silent_s", remote.silent_s},
          {"behind", hardware::Name(remote.behind)},
          {"key_known", remote.key_known},
          {"holder", remote.holder},
          {"held_by_us", remote.held_by_us},
          {"round_trip_s", remote.round_trip_s},
          {"clock_offset_s", NumberOrNull(remote.clock_offset_s)},
          {"refilled", remote.gaps_refilled},
          {"seen_epoch", seen ? json::value(static_cast<std::uint64_t>(*seen)) : nullptr},
          {"refusal", refusal ? json::value(hardware::Name(*refusal)) : nullptr}};
}

json::value CalibrationToJson(const std::optional<hardware::RemoteRigInfo>& remote, WallTime now) {
  if (!remote || remote->calibration.empty()) return nullptr;
  json::object out{{"text", remote->calibration}, {"age_days", nullptr}};
  if (const auto days = CalibrationAgeDays(remote->calibration, now)) out["age_days"] = *days;
  return out;
}

/// A run of a rig that is not heard may go on there and is waited for, but nobody knows.
hardware::RigState StateShown(const RigStatus& rig) {
  const bool lost = rig.remote && rig.remote->link == hardware::LinkState::kLost;
  return lost ? hardware::RigState::kOffline : rig.state;
}

bool IsInUse(const RigStatus& rig) {
  using enum hardware::RigState;
  const bool moves = rig.state == kArmed || rig.state == kRunning || rig.state == kStopping;
  return rig.leased || moves || (rig.remote && !rig.remote->holder.empty());
}

/// One sentence when a person should look; null when the rig is well.
json::value HealthOf(RigReader who, const RigStatus& rig) {
  if (rig.trip) return json::value(rig.trip->name + ": " + TextFor(who, *rig.trip));
  if (!rig.remote) return nullptr;
  if (rig.remote->refusal) return json::value(rig.remote->refusal_text);
  if (rig.remote->link == hardware::LinkState::kLost) return "the agent is not heard";
  if (rig.remote->link == hardware::LinkState::kLate) return "the agent is late";
  return nullptr;
}

}  // namespace

std::optional<int> CalibrationAgeDays(std::string_view calibration, WallTime now) {
  const std::optional<WallTime> dated = LeadingDate(calibration);
  if (!dated) return {};
  return std::chrono::floor<std::chrono::days>(now - *dated).count();
}

json::object RigToJson(const RigStatus& rig, WallTime now, RigReader who) {
  const hardware::RigDescription& about = rig.description;
  json::object out{{"id", about.id},
                   {"class", about.rig_class},
                   {"bench", about.bench != nullptr ? json::value(about.bench->id) : nullptr},
                   {"kind", hardware::Name(about.kind)},
                   {"profile", rig.profile},
                   {"state", hardware::Name(StateShown(rig))},
                   {"in_use", rig.leased},
                   {"epoch", static_cast<std::uint64_t>(rig.epoch)},
                   {"capabilities",
                    {{"um", about.has_um},
                     {"ua", about.has_ua},
                     {"ia", about.has_ia},
                     {"n", about.has_n},
                     {"any_value", about.any_value},
                     {"motor_faults", about.motor_faults},
                     {"controls_speed", about.controls_speed},
                     {"uc_v_min", about.uc_v_min},
                     {"uc_v_max", about.uc_v_max},
                     {"delta_s", about.delta_s},
                     {"amplifier", AmplifierToJson(about)}}},
                   {"health", HealthOf(who, rig)},
                   {"trip", TripToJson(who, rig.trip)},
                   {"link", rig.remote ? json::value(LinkToJson(*rig.remote)) : nullptr},
                   {"calibration", CalibrationToJson(rig.remote, now)},
                   {"loop", nullptr}};
  if (who == RigReader::kOperator && rig.loop.lateness.count() > 0) out["loop"] = ToJson(rig.loop);
  return out;
}

void AddRigMetrics(MetricsText& out, const std::vector<RigStatus>& rigs) {
  const auto each = [&](const auto& add) {
    for (const RigStatus& rig : rigs) {
      if (rig.loop.lateness.count() > 0) add(rig, Label("rig", rig.description.id));
    }
  };
  each([&](const RigStatus& rig, const std::string& label) {
    out.AddHistogram("faultlab_rig_lateness_seconds", rig.loop.lateness, label);
  });
  each([&](const RigStatus& rig, const std::string& label) {
    if (IsInUse(rig)) return;
    out.AddHistogram("faultlab_rig_command_seconds", rig.loop.actuation, label);
  });
  each([&](const RigStatus& rig, const std::string& label) {
    out.Add("faultlab_rig_loop_overruns_total", "counter", rig.loop.overruns, label);
  });
  each([&](const RigStatus& rig, const std::string& label) {
    out.Add("faultlab_rig_loop_missed_ticks_total", "counter", rig.loop.missed_ticks, label);
  });
  each([&](const RigStatus& rig, const std::string& label) {
    out.Add("faultlab_rig_fifo", "gauge", rig.loop.fifo ? 1 : 0, label);
  });
  for (const RigStatus& rig : rigs) {
    out.Add("faultlab_rig_tripped", "gauge", rig.trip ? 1 : 0, Label("rig", rig.description.id));
  }
  for (const RigStatus& rig : rigs) {
    if (!rig.remote) continue;
    const bool heard = rig.remote->link != hardware::LinkState::kLost;
    out.Add("faultlab_rig_heard", "gauge", heard ? 1 : 0, Label("rig", rig.description.id));
  }
}

}  // namespace faultlab::server
