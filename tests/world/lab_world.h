#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "server/storage/database.h"
#include "tests/world/memory_store.h"
#include "tests/world/world_member.h"

namespace faultlab::server::lab::rehearsal {

/// Where the worlds keep their labs.
struct WorldStore {
  /// One for each member. Empty: in memory. Every world empties the lab's tables first.
  std::vector<Database*> databases{};
};

/// One lab with random people and random faults.
class LabWorld {
 public:
  /// @param kind  any six in a row are all kinds of worlds: members, calm or storm
  LabWorld(std::uint64_t seed,
           std::uint64_t kind,
           const WorldStore& store,
           RehearsalReport& report);

  void Step();
  const Oracle& oracle() const { return site_.oracle; }
  /// "two members, storm", for the report.
  std::string About() const;

 private:
  struct Credential {
    SessionId session{};
    std::uint64_t epoch = 0;
  };

  void MakeRigs();
  void SetHours();
  void MakeMembers(const WorldStore& store);
  void Pass(WorldTime time);
  void Deliver();
  void Restart();
  void Misfortune();
  void Person(WorldMember& member, double dice);
  void AskForRig(WorldMember& member);
  void Accept(WorldMember& member);
  void Book(WorldMember& member);
  void BookWhatIsFree(WorldMember& member);
  void Claim(WorldMember& member);
  void Cancel(WorldMember& member);
  void End(WorldMember& member);
  void PassOn(WorldMember& member);
  void Extend(WorldMember& member);
  void Act(WorldMember& member);
  void Run(WorldMember& member);
  void Operate(WorldMember& member);
  void Remember(const Session& session);

  UserId AnyUser() { return UserId{1 + site_.random.Below(12)}; }
  std::string AnyClass();
  RigId AnyRig();
  WorldMember* AnyAwake();
  const Session* AnySession(const LabState& state);

  Site site_;
  std::shared_ptr<MemoryLab> memory_ = std::make_shared<MemoryLab>();
  std::vector<std::unique_ptr<WorldMember>> members_;
  std::vector<WorldTime> restart_at_;  ///< of each member
  std::vector<WorldTime> cut_until_;   ///< from the store
  std::vector<WorldTime> clock_back_;  ///< when the clock is set right; 0: it stays
  bool answer_lost_after_step_ = false;
  WorldTime clock_set_{-std::chrono::hours(1)};
  std::vector<Credential> credentials_;
};

}  // namespace faultlab::server::lab::rehearsal
