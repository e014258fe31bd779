#include "server/app/rig_watch.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace faultlab::server {
namespace {

using lab::AlarmKind;

constexpr auto kEvery = std::chrono::seconds(2);
/// A rig that is away for less is none: agents restart, and are heard after the server's start.
constexpr auto kSilentAfter = std::chrono::seconds(15);
/// Of the space that must stay free: an operator has some days to make room.
constexpr std::int64_t kReservesLeft = 4;

/// A kind whose text is the reason. The texts of the others have figures, which change by
/// themselves.
constexpr auto kHoursAhead = std::chrono::hours(24 * 14);

bool HasReason(AlarmKind kind) {
  return kind == AlarmKind::kQuarantined || kind == AlarmKind::kCheckFailed ||
         kind == AlarmKind::kSilent;
}

}  // namespace

RigWatch::RigWatch(Parts parts) : parts_(std::move(parts)) {
  parts_.rig_pool.SetTally(tally_);
  looks_.emplace(parts_.clock, Repeated::First::kAtOnce, kEvery, [this] {
    if (!std::exchange(looked_, true) && parts_.service.CameBack()) TellRestart();
    Look();
  });
}

RigWatch::~RigWatch() {
  looks_.reset();
  parts_.rig_pool.SetTally(nullptr);
  Store(tally_->Take());
}

void RigWatch::TellRestart() {
  const core::Status told =
      parts_.alarms.Raise(AlarmKind::kRestarted,
                          parts_.service.member(),
                          "it is running again; runs that were in progress are interrupted",
                          parts_.clock.Wall());
  if (!told.ok()) parts_.log("alarm: restart: " + told.error().message);
}

bool RigWatch::Leads() const {
  const std::vector<lab::Member> others = parts_.service.Others();
  return std::ranges::none_of(
      others, [this](const lab::Member& each) { return each.id < parts_.service.member(); });
}

void RigWatch::Look() {
  Store(tally_->Take());
  const auto state = parts_.service.state();
  const Causes causes = Find(*state, parts_.rig_pool.List());
  const auto open = parts_.alarms.Open();
  if (!open.ok()) return;  // the database is away, which /readyz tells
  std::set<Cause> raised;
  const WallTime now = parts_.clock.Wall();
  for (const lab::Alarm& alarm : open.value()) {
    const Cause cause{alarm.kind, alarm.subject};
    raised.insert(cause);
    if (!lab::Lasts(alarm.kind) || !IsMine(cause, *state)) continue;
    const auto found = causes.find(cause);
    const bool lasts = found != causes.end();
    const bool is_other = lasts && HasReason(alarm.kind) && found->second != alarm.text;
    if (lasts && !is_other) continue;
    (void)parts_.alarms.End(alarm.kind, alarm.subject, now);
    raised.erase(cause);
  }
  for (const auto& [cause, text] : causes) {
    if (raised.contains(cause)) continue;
    const core::Status told = parts_.alarms.Raise(cause.first, cause.second, text, now);
    if (!told.ok()) parts_.log("alarm: " + cause.second + ": " + told.error().message);
  }
}

void RigWatch::Store(const RigTally::Taken& taken) {
  const WallTime now = parts_.clock.Wall();
  for (const auto& [rig, closings] : taken.closings) {
    worn_.erase(rig);
    const core::Status stored = parts_.wear.Add(rig, closings, now);
    if (!stored.ok()) parts_.log("rig " + rig + ": its relay cycles: " + stored.error().message);
  }
  const auto state = parts_.service.state();
  for (const RigTally::News& news : taken.news) {
    const auto rig = state->rigs.find(news.rig);
    if (rig == state->rigs.end() || rig->second.elastic) continue;
    const bool trip = news.event == RigTally::Event::kTrip;
    const core::Status told = parts_.alarms.Raise(
        trip ? AlarmKind::kInterlock : AlarmKind::kDeltaStrays, news.rig, news.text, now);
    if (!told.ok()) parts_.log("alarm: " + news.rig + ": " + told.error().message);
  }
}

RigWatch::Causes RigWatch::Find(const lab::LabState& state, const std::vector<RigStatus>& rigs) {
  Causes causes;
  AddStates(state, causes);
  for (const RigStatus& rig : rigs) {
    const std::string& id = rig.description.id;
    const auto known = state.rigs.find(id);
    if (known == state.rigs.end() || known->second.elastic) continue;
    if (rig.trip) causes[{AlarmKind::kInterlock, id}] = rig.trip->text;
    AddRelays(rig, causes);
  }
  AddHours(state, causes);
  AddDisk(causes);
  return causes;
}

void RigWatch::AddStates(const lab::LabState& state, Causes& causes) {
  const MonotonicTime now = parts_.clock.Monotonic();
  for (const auto& [id, rig] : state.rigs) {
    if (rig.elastic) continue;
    if (rig.status != lab::RigStatus::kOffline) silent_since_.erase(id);
    if (rig.status == lab::RigStatus::kQuarantined) {
      const bool says_so = rig.check_failed && rig.reason.starts_with(lab::kCheckFailedText);
      causes[{rig.check_failed ? AlarmKind::kCheckFailed : AlarmKind::kQuarantined, id}] =
          says_so ? rig.reason.substr(lab::kCheckFailedText.size()) : rig.reason;
    } else if (rig.status == lab::RigStatus::kOffline) {
      const MonotonicTime since = silent_since_.try_emplace(id, now).first->second;
      if (now - since >= kSilentAfter) causes[{AlarmKind::kSilent, id}] = rig.reason;
    }
  }
}

/// After its last opening time a class stays closed.
void RigWatch::AddHours(const lab::LabState& state, Causes& causes) const {
  std::map<std::string, WallTime> last;
  for (const auto& [id, window] : state.windows) {
    if (window.course != 0) continue;
    WallTime& end = last[window.rig_class];
    end = std::max(end, window.times.back().end);
  }
  const WallTime now = parts_.clock.Wall();
  for (const auto& [rig_class, end] : last) {
    if (end - now > kHoursAhead) continue;
    causes[{AlarmKind::kHoursEnd, rig_class}] =
        "the last opening hours end at " + lab::UtcText(end) + "; then the rigs stay closed";
  }
}

void RigWatch::AddRelays(const RigStatus& rig, Causes& causes) {
  const hardware::RigDescription& about = rig.description;
  if (about.any_value || about.bench == nullptr) return;
  auto known = worn_.find(about.id);
  if (known == worn_.end()) {
    const auto counts = parts_.wear.Get(about.id);
    if (!counts.ok()) return;
    std::string text;
    for (const auto& [line, count] : counts.value()) {
      const double share = static_cast<double>(count.cycles) / about.bench->limits.relay_life;
      if (share < lab::RelayWear::kWarnShare) continue;
      text += (text.empty() ? "Do" : ", Do") + std::to_string(line) + ": " +
              std::to_string(count.cycles);
    }
    known = worn_.emplace(about.id, std::move(text)).first;
  }
  if (!known->second.empty()) causes[{AlarmKind::kRelayWorn, about.id}] = known->second;
}

void RigWatch::AddDisk(Causes& causes) const {
  if (parts_.disk.folder.empty() || parts_.disk.bytes == 0) return;
  std::error_code failed;
  const auto space = std::filesystem::space(parts_.disk.folder, failed);
  const auto free = static_cast<std::int64_t>(space.available);
  if (failed || free >= kReservesLeft * parts_.disk.bytes) return;
  causes[{AlarmKind::kStorageSmall, parts_.service.member()}] =
      std::to_string(free >> 20) + " MB are free; below " +
      std::to_string(parts_.disk.bytes >> 20) + " MB nothing is recorded";
}

bool RigWatch::IsMine(const Cause& cause, const lab::LabState& state) const {
  const auto& [kind, subject] = cause;
  switch (kind) {
    case AlarmKind::kQuarantined:
    case AlarmKind::kCheckFailed:
    case AlarmKind::kSilent:
    case AlarmKind::kHoursEnd:
      return Leads();
    case AlarmKind::kStorageSmall:
      return subject == parts_.service.member();
    case AlarmKind::kInterlock:
    case AlarmKind::kRelayWorn:
    case AlarmKind::kDeltaStrays:
      break;
    case AlarmKind::kRestarted:
    case AlarmKind::kJobFailed:
      return false;
  }
  const auto rig = state.rigs.find(subject);
  return rig != state.rigs.end() && rig->second.server == parts_.service.member();
}

}  // namespace faultlab::server
