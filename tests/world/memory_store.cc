#include "tests/world/memory_store.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace faultlab::server::lab::rehearsal {
namespace {

bool Lives(const Ticket& ticket) {
  return ticket.state == TicketState::kWaiting || ticket.state == TicketState::kOffered;
}
bool Lives(const Booking& booking) {
  return IsLive(booking);
}
bool Lives(const Session& session) {
  return session.state != SessionState::kClosed;
}

template <typename Map, typename Value>
void Put(Map& map, const std::vector<Value>& changed) {
  for (const Value& value : changed) {
    if (Lives(value)) {
      map[value.id] = value;
    } else {
      map.erase(value.id);
    }
  }
}

/// Writes to a side until the transaction commits.
class MemoryTurn : public LabTurn {
 public:
  MemoryTurn(const MemoryLab& lab, const std::function<WallTime()>& time)
      : lab_(lab), time_(time) {}

  std::int64_t LockVersion() override { return lab_.version; }
  LabState Load() override { return lab_.state; }
  void Save(const Changes& changes, std::int64_t version) override {
    changes_ = changes;
    version_ = version;
  }
  void AddEvents(const std::vector<LabEvent>& events) override { events_ = events; }
  void NoteUse(const LabState&, const std::vector<Rig>&, WallTime) override {}
  void StoodStill(WallTime) override {}
  std::vector<Member> Members() override { return members_ ? *members_ : lab_.members; }
  void PutMember(const Member& member) override {
    std::vector<Member> all = Members();
    std::erase_if(all, [&](const Member& each) { return each.id == member.id; });
    all.push_back(member);
    std::sort(all.begin(), all.end(), [](const Member& a, const Member& b) { return a.id < b.id; });
    members_ = std::move(all);
  }
  void RemoveMember(const std::string& id, WallTime) override {
    std::vector<Member> all = Members();
    std::erase_if(all, [&](const Member& each) { return each.id == id; });
    members_ = std::move(all);
  }
  WallTime StoreTime() override { return time_(); }
  std::vector<std::string> RunsOfPastLeases(const std::string&, WallTime) override { return {}; }
  void InterruptRun(const std::string&, WallTime) override {}
  void InterruptRunsOf(const std::string&, WallTime) override {}

  void CommitTo(MemoryLab& lab) {
    if (changes_) {
      for (const Rig& rig : changes_->rigs) lab.state.rigs[rig.id] = rig;
      for (const Outage& outage : changes_->outages) lab.state.outages[outage.id] = outage;
      for (const OutageId id : changes_->ended_outages) lab.state.outages.erase(id);
      for (const Window& window : changes_->windows) lab.state.windows[window.id] = window;
      for (const WindowId id : changes_->ended_windows) lab.state.windows.erase(id);
      Put(lab.state.tickets, changes_->tickets);
      Put(lab.state.bookings, changes_->bookings);
      Put(lab.state.sessions, changes_->sessions);
      for (const Usage& usage : changes_->usage) lab.state.usage[usage.user] = usage;
      for (const auto& [rig_class, settings] : changes_->settings) {
        if (settings) lab.state.settings[rig_class] = *settings;
        if (!settings) lab.state.settings.erase(rig_class);
      }
      lab.state.next_id = changes_->next_id;
      lab.version = version_;
    }
    if (members_) lab.members = std::move(*members_);
    if (!lab.keep_events) return;
    for (LabEvent& event : events_) {
      event.seq = static_cast<std::int64_t>(lab.events.size()) + 1;
      lab.events.push_back(std::move(event));
    }
  }

 private:
  const MemoryLab& lab_;
  const std::function<WallTime()>& time_;
  std::optional<Changes> changes_;
  std::int64_t version_ = 0;
  std::optional<std::vector<Member>> members_;
  std::vector<LabEvent> events_;
};

}  // namespace

core::Status MemoryStore::Write(const std::function<core::Status(LabTurn&)>& turn) {
  MemoryTurn open(*lab_, time_);
  core::Status done = turn(open);
  if (done.ok()) open.CommitTo(*lab_);
  return done;
}

core::Result<std::vector<LabEvent>> MemoryStore::EventsSince(UserId user,
                                                             std::int64_t since,
                                                             int limit) {
  std::vector<LabEvent> out;
  for (const LabEvent& event : lab_->events) {
    if (static_cast<int>(out.size()) == limit) break;
    if (event.user == user && event.seq > since) out.push_back(event);
  }
  return out;
}

}  // namespace faultlab::server::lab::rehearsal
