#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "server/api/lab/feed.h"
#include "server/app/job_runner.h"
#include "server/auth/calendar_links.h"
#include "server/clock.h"
#include "server/lab/fault_sets.h"
#include "server/lab/job_store.h"
#include "server/lab/lab_service.h"
#include "server/lab/remembered_answers.h"
#include "server/lab/retention.h"
#include "server/lab/rig_bands.h"

namespace faultlab::server {

/// The lab around the experiments: sessions on the rigs that need one, the check between users,
/// jobs. Sits between LabService, which decides, and RigBay and RunManager, which do.
class LabSystem {
 public:
  struct Options {
    std::string server_id;
    std::string address;  ///< "host:port", for the other servers of this database
    std::function<void(std::string_view)> log;
    int job_workers = 2;
    lab::RetentionRules retention;
  };
  /// Opens the lab, fills `api.lab`, `api.hold_rig` and `api.may_command`, starts to work.
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
  LabSystem(Database& database, Accounts& accounts, ApiContext& api, Options options);
  void FollowRigs();
  void CheckLoop();
  lab::RigVerdict Check(const lab::Lease& lease);
  lab::RigVerdict CheckHeld(RigHold& hold);
  void RetainDaily();
  bool WaitForStop(std::chrono::milliseconds patience);
  static const lab::Session* SessionOf(const lab::LabState& state,
                                       const Principal& who,
                                       const std::string& rig);
  bool MayCommand(const Principal& who, const std::string& rig) const;
  core::Result<lab::Lease> LeaseFor(const Principal& who,
                                    const std::string& rig,
                                    std::chrono::milliseconds length);
  core::Result<RigHold> HoldRig(const Principal& who,
                                const std::string& rig,
                                std::chrono::milliseconds length);
  void GiveBack(const lab::Lease& lease);

  ApiContext& api_;
  const Options options_;
  lab::JobStore jobs_;
  lab::FaultSets fault_sets_;
  lab::RememberedAnswers answers_;
  CalendarLinks calendar_links_;
  lab::RigBands bands_;
  Database& database_;
  Accounts& accounts_;
  // What the service's thread touches stands above the service: it goes after it.
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<lab::Lease> checks_;
  std::map<lab::RigId, std::set<CheckExtra>> extras_;  ///< of the next check
  std::unique_ptr<Duties> duties_;
  std::unique_ptr<lab::LabService> service_;
  std::unique_ptr<LabApi> lab_api_;
  std::unique_ptr<LabFeed> feed_;

  bool stopping_ = false;
  WallTime next_retention_{};  ///< of the thread that follows the rigs
  std::unique_ptr<JobRunner> jobs_runner_;
  std::vector<std::thread> threads_;
};

}  // namespace faultlab::server
