#include "server/lab/lab_store.h"
#include "server/lab/rig_use.h"
#include "server/storage/recording_store.h"

namespace faultlab::server::lab {
namespace {

class DatabaseTurn : public LabTurn {
 public:
  explicit DatabaseTurn(Transaction& tx) : tx_(tx) {}

  std::int64_t LockVersion() override { return lab_store::LockVersion(tx_); }
  LabState Load() override { return lab_store::Load(tx_); }
  void Save(const Changes& changes, std::int64_t version) override {
    lab_store::Save(tx_, changes, version);
  }
  void AddEvents(const std::vector<LabEvent>& events) override {
    lab_store::AddEvents(tx_, events);
  }
  void NoteUse(const LabState& state, const std::vector<Rig>& rigs, WallTime now) override {
    rig_use::Note(tx_, state, rigs, now);
  }
  void StoodStill(WallTime from) override { rig_use::StoodStill(tx_, from); }
  std::vector<Member> Members() override { return members::Load(tx_); }
  void PutMember(const Member& member) override { members::Put(tx_, member); }
  void RemoveMember(const std::string& id, WallTime now) override { members::Remove(tx_, id, now); }
  WallTime StoreTime() override { return members::DatabaseTime(tx_); }
  std::vector<std::string> RunsOfPastLeases(const std::string& server, WallTime now) override {
    return lab_store::RunsOfPastLeases(tx_, server, now);
  }
  void InterruptRun(const std::string& run, WallTime now) override {
    server::InterruptRun(tx_, run, now);
  }
  void InterruptRunsOf(const std::string& server, WallTime now) override {
    (void)InterruptRuns(tx_, server, now);
  }

 private:
  Transaction& tx_;
};

}  // namespace

core::Status DatabaseLabStore::Write(const std::function<core::Status(LabTurn&)>& turn) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    DatabaseTurn open(tx);
    return turn(open);
  });
}

core::Result<std::vector<LabEvent>> DatabaseLabStore::EventsSince(UserId user,
                                                                  std::int64_t since,
                                                                  int limit) {
  return database_.Read(
      [&](Transaction& tx) { return lab_store::EventsSince(tx, user, since, limit); });
}

}  // namespace faultlab::server::lab
