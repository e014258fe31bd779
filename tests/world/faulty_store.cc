#include "tests/world/faulty_store.h"

#include <string>
#include <utility>

#include "server/storage/database_error.h"

namespace faultlab::server::lab::rehearsal {
namespace {

core::Error Away() {
  return {core::ErrorCode::kUnavailable,
          "the database does not answer",
          "",
          std::string(kDatabaseAway)};
}

/// Passes everything on, and keeps the messages.
class HeardTurn : public LabTurn {
 public:
  explicit HeardTurn(LabTurn& turn) : turn_(turn) {}
  std::int64_t LockVersion() override { return turn_.LockVersion(); }
  LabState Load() override { return turn_.Load(); }
  void Save(const Changes& changes, std::int64_t version) override { turn_.Save(changes, version); }
  void AddEvents(const std::vector<LabEvent>& events) override {
    events_ = events;
    turn_.AddEvents(events);
  }
  void NoteUse(const LabState& state, const std::vector<Rig>& rigs, WallTime now) override {
    turn_.NoteUse(state, rigs, now);
  }
  void StoodStill(WallTime from) override { turn_.StoodStill(from); }
  std::vector<Member> Members() override { return turn_.Members(); }
  void PutMember(const Member& member) override { turn_.PutMember(member); }
  void RemoveMember(const std::string& id, WallTime now) override { turn_.RemoveMember(id, now); }
  WallTime StoreTime() override { return turn_.StoreTime(); }
  std::vector<std::string> RunsOfPastLeases(const std::string& server, WallTime now) override {
    return turn_.RunsOfPastLeases(server, now);
  }
  void InterruptRun(const std::string& run, WallTime now) override { turn_.InterruptRun(run, now); }
  void InterruptRunsOf(const std::string& server, WallTime now) override {
    turn_.InterruptRunsOf(server, now);
  }
  const std::vector<LabEvent>& events() const { return events_; }

 private:
  LabTurn& turn_;
  std::vector<LabEvent> events_;
};

}  // namespace

core::Status FaultyStore::Write(const std::function<core::Status(LabTurn&)>& turn) {
  if (faults_.away) return Away();
  const NextWrite next = std::exchange(faults_.next, NextWrite::kStored);
  std::vector<LabEvent> events;
  const core::Status stored = store_->Write([&](LabTurn& open) -> core::Status {
    HeardTurn heard(open);
    core::Status done = turn(heard);
    if (!done.ok()) return done;
    if (next == NextWrite::kCrashBefore || next == NextWrite::kRefused) return Away();
    events = heard.events();
    return done;
  });
  if (next == NextWrite::kCrashBefore) throw Crash{};
  if (!stored.ok()) return stored;
  if (faults_.told) faults_.told(events);
  if (next == NextWrite::kCrashAfter) throw Crash{};
  if (next == NextWrite::kAnswerLost) return Away();
  ++faults_.stored;
  return stored;
}

}  // namespace faultlab::server::lab::rehearsal
