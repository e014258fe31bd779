#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/lab/members.h"
#include "server/lab/scheduler.h"
#include "server/storage/database.h"

namespace faultlab::server::lab {

/// One message to a user.
struct LabEvent {
  std::int64_t seq = 0;
  UserId user{};
  WallTime at{};
  std::string topic;
  std::string text;
  SessionId session{};
  RigId rig;                       ///< empty: of no certain rig
  UserId other{};                  ///< who did it, or got it; none: the lab itself
  std::string why;                 ///< the words of a person or of the rig; may be empty
  std::string reason;              ///< of the lab, a word of Notice
  std::optional<WallTime> time{};  ///< of Notice
  WallTime session_start{};        ///< as read back; `at` if there is no session
};

/// What one turn of a server reads and writes. All of it is stored together, or nothing.
class LabTurn {
 public:
  virtual ~LabTurn() = default;
  /// Increases with every stored transition. Where servers share the store, the others wait until
  /// this turn ends, so that they change the lab one after the other. Called first.
  virtual std::int64_t LockVersion() = 0;
  /// Everything that has not ended.
  virtual LabState Load() = 0;
  /// Stores the changes and the next version. Things that have ended stay as history.
  virtual void Save(const Changes& changes, std::int64_t version) = 0;
  virtual void AddEvents(const std::vector<LabEvent>& events) = 0;
  /// What these rigs are used for from now on (rig_use.h).
  virtual void NoteUse(const LabState& state, const std::vector<Rig>& rigs, WallTime now) = 0;
  /// No server was alive since `from`: the rigs were not used.
  virtual void StoodStill(WallTime from) = 0;
  virtual std::vector<Member> Members() = 0;
  virtual void PutMember(const Member& member) = 0;
  /// Removes a member and interrupts its runs: nothing more is recorded into them.
  virtual void RemoveMember(const std::string& id, WallTime now) = 0;
  /// The time of the store's machine, with which the members' clocks are compared. Only of a shared
  /// store.
  virtual WallTime StoreTime() = 0;
  /// Runs of this server, of the last day, that are stored as running although their rig has had a
  /// newer lease since: they are about to end, or their end was not stored.
  virtual std::vector<std::string> RunsOfPastLeases(const std::string& server, WallTime now) = 0;
  virtual void InterruptRun(const std::string& run, WallTime now) = 0;
  virtual void InterruptRunsOf(const std::string& server, WallTime now) = 0;
};

/// Where LabService keeps the lab. The server uses DatabaseLabStore; the rehearsal also one in
/// memory.
class LabStore {
 public:
  virtual ~LabStore() = default;
  /// Runs `turn` in one transaction. An error of the turn or of the store: nothing is stored, or,
  /// if the connection was lost at the end, it is unknown whether it was.
  virtual core::Status Write(const std::function<core::Status(LabTurn&)>& turn) = 0;
  /// Events of one user after `since`, oldest first.
  virtual core::Result<std::vector<LabEvent>> EventsSince(UserId user,
                                                          std::int64_t since,
                                                          int limit) = 0;
  /// Whether servers on several machines use it, whose clocks NTP must keep.
  virtual bool shared() const = 0;
};

/// The lab in the tables of SQLite or PostgreSQL (shared).
class DatabaseLabStore : public LabStore {
 public:
  explicit DatabaseLabStore(Database& database) : database_(database) {}
  core::Status Write(const std::function<core::Status(LabTurn&)>& turn) override;
  core::Result<std::vector<LabEvent>> EventsSince(UserId user,
                                                  std::int64_t since,
                                                  int limit) override;
  bool shared() const override { return database_.engine() == Engine::kPostgresql; }

 private:
  Database& database_;
};

/// The scheduler's state in tables. Every function takes part in the caller's transaction and
/// throws what the database throws.
namespace lab_store {

/// On PostgreSQL the row stays locked until the transaction ends.
std::int64_t LockVersion(Transaction& tx);
std::vector<std::string> RunsOfPastLeases(Transaction& tx,
                                          const std::string& server_id,
                                          WallTime now);
LabState Load(Transaction& tx);
void Save(Transaction& tx, const Changes& changes, std::int64_t version);
void AddEvents(Transaction& tx, const std::vector<LabEvent>& events);
std::vector<LabEvent> EventsSince(Transaction& tx, UserId user, std::int64_t since, int limit);
/// The ended sessions of a person, newest first; jobs and practice are none.
/// @param before  those with a smaller id
std::vector<Session> PastSessions(Transaction& tx, UserId user, SessionId before, int limit);
/// Why this session has ended; kNone while it goes on, and when it is not known.
EndReason EndReasonOf(Transaction& tx, SessionId session);
/// Whether an outage has taken time from the session after it had begun.
bool WasShortened(Transaction& tx, SessionId session);
/// The newest sequence number of a user, 0 when there is none.
std::int64_t NewestEvent(Transaction& tx, UserId user);

}  // namespace lab_store
}  // namespace faultlab::server::lab
