#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "server/experiment/benches.h"
#include "server/lab/check_log.h"
#include "server/lab/lab_service.h"
#include "server/lab/rig_bands.h"
#include "server/lab/rig_check.h"
#include "server/run/rig_pool.h"
#include "server/upkeep/asked_checks.h"
#include "server/upkeep/check_extra.h"
#include "server/upkeep/roll_call.h"

namespace faultlab::server {

/// Manages the rigs of this server: tells the lab which ones exist and whether they answer, fences
/// them when the lab requires it, checks them between users.
///
///   RigPool --rigs come and go--> RigUpkeep --> LabService
///   LabService --Fence, StartCleaning--> RigUpkeep --> RigPool, the check --verdict--> LabService
class RigUpkeep : public lab::RigDuties {
 public:
  /// All must outlive it.
  /// @param follow  between two looks at the rigs, and before a verdict is stored once more
  RigUpkeep(RigPool& rig_pool,
            lab::RigBands& bands,
            lab::CheckLog& check_log,
            Benches& benches,
            const Clock& clock,
            std::function<void(std::string_view)> log,
            std::chrono::milliseconds follow = std::chrono::seconds(1));
  ~RigUpkeep() override;  ///< Stop()
  RigUpkeep(const RigUpkeep&) = delete;
  RigUpkeep& operator=(const RigUpkeep&) = delete;

  /// The service already has these duties, and must exist until Stop.
  void Start(lab::LabService& service);
  /// Starts no new checks; waits for those in progress.
  void Stop();

  void WithNextCheck(const std::string& rig, CheckExtra extra);
  /// None before the first check of the contacts.
  std::optional<RigContacts> ContactsOf(const std::string& rig) const;

  void Fence(const lab::RigId& rig, std::uint64_t epoch) override;
  void StartCleaning(const lab::Lease& lease) override;
  bool RunInProgress(const lab::RigId& rig) override;

 private:
  void FollowRigs();
  void FollowBenches(const std::vector<RigStatus>& rigs);
  void CheckLoop();
  lab::RigVerdict Check(const lab::Lease& lease, std::string& kind);
  lab::RigVerdict CheckHeld(RigHandle& hold, const std::set<CheckExtra>& extras);
  lab::RigVerdict CheckContactsOf(RigHandle& hold);
  std::set<CheckExtra> TakeExtras(const std::string& rig);
  void LogCheck(const std::string& rig, const std::string& kind, const lab::RigVerdict& verdict);
  bool WaitForStop(std::chrono::milliseconds patience);

  RigPool& rig_pool_;
  lab::RigBands& bands_;
  lab::CheckLog& check_log_;
  Benches& benches_;
  const Clock& clock_;
  const std::function<void(std::string_view)> log_;
  const std::chrono::milliseconds follow_;
  lab::LabService* service_ = nullptr;
  std::optional<RollCall> roll_call_;  ///< since Start; of the thread that follows rigs
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  AskedChecks checks_;
  std::map<lab::RigId, std::set<CheckExtra>> extras_;  ///< of the next check
  std::map<lab::RigId, RigContacts> contacts_;
  std::map<lab::RigId, const core::Bench*> stored_benches_;  ///< of the thread that follows rigs
  std::set<lab::RigId> rebuilt_;  ///< those whose bands and sessions have not been ended yet
  std::vector<std::thread> threads_;
};

}  // namespace faultlab::server
