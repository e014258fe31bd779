#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/api/lab_api.h"
#include "server/clock.h"
#include "server/lab/fault_sets.h"
#include "server/lab/job_store.h"
#include "server/lab/lab_service.h"
#include "server/lab/remembered_answers.h"

namespace faultlab::server {

/// The lab around the experiments: sessions on the rigs that need one, the check between users,
/// jobs. Sits between LabService, which decides, and RigBay and RunManager, which do.
class LabSystem {
 public:
  struct Options {
    std::string server_id;
    std::function<void(std::string_view)> log;
    int job_workers = 2;
  };
  /// Opens the lab, fills `api.lab` and `api.may_use_rig`, starts to work.
  static core::Result<std::unique_ptr<LabSystem>> Open(Database& database,
                                                       Accounts& accounts,
                                                       ApiContext& api,
                                                       Options options);
  ~LabSystem();  ///< Stop()
  /// No new checks and jobs; those that run are waited for. Before RunManager::Shutdown.
  void Stop();

  lab::LabService& service() { return *service_; }

 private:
  class Duties;
  struct Check {
    lab::RigId rig;
    std::uint64_t epoch = 0;
  };

  LabSystem(Database& database, Accounts& accounts, ApiContext& api, Options options);
  void FollowRigs();
  void CheckLoop();
  void JobLoop();
  void DoJob(const lab::Job& job);
  bool WaitForStop(std::chrono::milliseconds patience);
  core::Status MayUse(const Principal& who, std::string_view rig) const;

  ApiContext& api_;
  const Options options_;
  lab::JobStore jobs_;
  lab::FaultSets fault_sets_;
  lab::RememberedAnswers answers_;
  Accounts& accounts_;
  std::unique_ptr<Duties> duties_;
  std::unique_ptr<lab::LabService> service_;
  std::unique_ptr<LabApi> lab_api_;

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Check> checks_;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace faultlab::server
