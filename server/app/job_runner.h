#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "server/experiment/experiments.h"
#include "server/experiment/work.h"
#include "server/lab/job_store.h"

namespace faultlab::server {

/// Executes jobs (rule 12 of server/lab): claims them, runs them, renews their leases. A run on a
/// rig that needs a session waits in the rig's queue with the lowest weight, gets a session of its
/// own and gives the rig back after each run, so that a person never waits longer than one run.
class JobRunner {
 public:
  struct Parts {
    lab::JobStore& jobs;
    lab::LabService& service;
    Accounts& accounts;
    Experiments& experiments;
    Recordings& recordings;
    RunManager& runs;
    RecordingStore& store;
    const Clock& clock;
  };
  struct Options {
    std::string server_id;
    int workers = 2;
    std::function<void(std::string_view)> log;
  };
  /// All parts must outlive the runner.
  JobRunner(Parts parts, Options options);
  ~JobRunner();  ///< Stop()
  JobRunner(const JobRunner&) = delete;
  JobRunner& operator=(const JobRunner&) = delete;
  /// Starts no new jobs; the job of a run in progress waits for the next start.
  void Stop();

 private:
  void Loop();
  void Do(const lab::Job& job);
  /// The account that owns the job, in its present state. nullopt: deleted or disabled.
  std::optional<Principal> OwnerOf(const lab::Job& job) const;
  void DoDiagnosis(const lab::Job& job, const Principal& who, const DiagnosisRequest& request);
  void DoRun(const lab::Job& job, const Principal& who, ExperimentPlan plan);
  /// The rig that the job may use now: "" if any simulator is suitable, nullopt if the job must
  /// wait.
  core::Result<std::optional<std::string>> RigFor(const lab::Job& job, const ExperimentPlan& plan);
  bool IsElastic(const std::string& rig) const;
  void Follow(const lab::Job& job, const std::string& run);
  void Finish(const lab::Job& job, const std::string& state, const std::string& error);
  void GiveBack(const lab::Job& job);
  template <typename T>
  void Log(const core::Result<T>& done) const {
    if (!done.ok()) options_.log("jobs: " + done.error().message);
  }
  bool WaitForStop(std::chrono::milliseconds patience);

  const Parts parts_;
  const Options options_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace faultlab::server
