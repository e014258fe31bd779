#include "server/api/rig_json.h"

#include <boost/json.hpp>
#include <chrono>

#include "server/api/iso8601.h"
#include "server/run/loop_json.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

json::value TripToJson(const std::optional<hardware::Trip>& trip) {
  if (!trip) return nullptr;
  return json::object{{"name", trip->name},
                      {"value", trip->value},
                      {"limit", trip->limit},
                      {"index", trip->index},
                      {"t_s", trip->t_s},
                      {"text", trip->text}};
}

json::object AmplifierToJson(const hardware::RigDescription& about) {
  const bool current = about.amplifier_mode == core::AmplifierMode::kCurrent;
  const bool four = about.amplifier_quadrants == core::Quadrants::kFour;
  return {{"mode", current ? "current" : "voltage"}, {"quadrants", four ? 4 : 2}};
}

json::object LinkToJson(const hardware::RemoteRigInfo& remote) {
  json::object out{{"state", hardware::Name(remote.link)},
                   {"silent_s", remote.silent_s},
                   {"behind", hardware::Name(remote.behind)},
                   {"key_known", remote.key_known},
                   {"holder", remote.holder},
                   {"held_by_us", remote.held_by_us},
                   {"round_trip_s", remote.round_trip_s},
                   {"clock_offset_s", nullptr},
                   {"refilled", remote.gaps_refilled},
                   {"seen_epoch", nullptr},
                   {"refusal", nullptr}};
  if (remote.clock_offset_s) out["clock_offset_s"] = *remote.clock_offset_s;
  if (remote.epoch) out["seen_epoch"] = static_cast<std::uint64_t>(*remote.epoch);
  if (remote.refusal) out["refusal"] = hardware::Name(*remote.refusal);
  return out;
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

/// One sentence when a person should look; null when the rig is well.
json::value HealthOf(const RigStatus& rig) {
  if (rig.trip) return json::value(rig.trip->name + ": " + rig.trip->text);
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

json::object RigToJson(const RigStatus& rig, WallTime now) {
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
                     {"uc_v_min", about.uc_v_min},
                     {"uc_v_max", about.uc_v_max},
                     {"delta_s", about.delta_s},
                     {"amplifier", AmplifierToJson(about)}}},
                   {"health", HealthOf(rig)},
                   {"trip", TripToJson(rig.trip)},
                   {"link", nullptr},
                   {"calibration", CalibrationToJson(rig.remote, now)},
                   {"loop", nullptr}};
  if (rig.remote) out["link"] = LinkToJson(*rig.remote);
  if (rig.loop.lateness.count() > 0) out["loop"] = ToJson(rig.loop);
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
