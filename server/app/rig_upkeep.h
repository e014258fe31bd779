#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "server/api/sharing/handlers.h"
#include "server/lab/lab_service.h"
#include "server/lab/rig_bands.h"
#include "server/lab/rig_check.h"
#include "server/run/rig_bay.h"

namespace faultlab::server {

/// Looks after the rigs of this server: tells the lab which there are and whether they answer,
/// fences them as the lab says, checks them between users.
///
///   RigBay --rigs come and go--> RigUpkeep --> LabService
///   LabService --Fence, StartCleaning--> RigUpkeep --> RigBay, the check --verdict--> LabService
class RigUpkeep : public lab::RigDuties {
 public:
  /// All must outlive it.
  RigUpkeep(RigBay& bay,
            lab::RigBands& bands,
            const Clock& clock,
            std::function<void(std::string_view)> log);
  ~RigUpkeep() override;  ///< Stop()
  RigUpkeep(const RigUpkeep&) = delete;
  RigUpkeep& operator=(const RigUpkeep&) = delete;

  /// The service has these duties already, and lives until Stop.
  void Start(lab::LabService& service);
  /// No new checks; one that runs is waited for.
  void Stop();

  void WithNextCheck(const std::string& rig, CheckExtra extra);

  void Fence(const lab::RigId& rig, std::uint64_t epoch) override;
  void StartCleaning(const lab::Lease& lease) override;
  bool RunInProgress(const lab::RigId& rig) override;

 private:
  void FollowRigs();
  void CheckLoop();
  lab::RigVerdict Check(const lab::Lease& lease);
  lab::RigVerdict CheckHeld(RigHold& hold);
  bool WaitForStop(std::chrono::milliseconds patience);

  RigBay& bay_;
  lab::RigBands& bands_;
  const Clock& clock_;
  const std::function<void(std::string_view)> log_;
  lab::LabService* service_ = nullptr;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  std::deque<lab::Lease> checks_;
  std::map<lab::RigId, std::set<CheckExtra>> extras_;  ///< of the next check
  std::vector<std::thread> threads_;
};

}  // namespace faultlab::server
