#pragma once

#include <chrono>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "server/app/doorbell.h"
#include "server/app/job_places.h"
#include "server/experiment/experiments.h"
#include "server/jobs/job_store.h"
#include "server/lab/alarms.h"

namespace faultlab::server {

/// Executes jobs (rule 12 of server/lab). A job is claimed only when it can begin: when one of this
/// server's places is free, or when the lab has given its rig to it. It holds neither while it
/// waits.
///
///   a job is added, a job ends, the lab changes --> Doorbell --> one thread that asks the lab for
///   benches and claims jobs --> a thread for each job in progress
///
/// A run on a rig that needs a session waits in the rig's queue with the lowest weight, gets a
/// session of its own and gives the rig back after each run, so that a person never waits longer
/// than one run.
///
/// No owner's jobs stop another's: of each kind of places the last is kept for somebody else
/// (JobPlaces::ShareOf), a job that would wait for a rig or for the turn of long recordings goes
/// back into the queue, and one that has that turn gives it up after a method when another owner's
/// waits for it.
class JobRunner {
 public:
  struct Parts {
    JobStore& jobs;
    lab::LabService& service;
    Accounts& accounts;
    Experiments& experiments;
    Recordings& recordings;
    RunManager& runs;
    RecordingStore& store;
    const Clock& clock;
    Doorbell& bell;  ///< rung whenever a job was added or the lab has changed
    lab::Alarms& alarms;
  };
  struct Options {
    JobPlaces places;
    std::function<void(std::string_view)> log;
  };
  /// All parts must outlive the runner.
  JobRunner(Parts parts, Options options);
  ~JobRunner();  ///< Stop()
  JobRunner(const JobRunner&) = delete;
  JobRunner& operator=(const JobRunner&) = delete;
  /// Starts no new jobs and stops the runs of those in progress, which wait again.
  void Stop();

 private:
  using Steady = std::chrono::steady_clock::time_point;
  /// A job that this server has claimed.
  struct InProgress {
    Job job;
    std::string bench;  ///< of the job's session; empty: the job takes a place
    std::string run;
    bool over = false;  ///< its run is to be stopped
    bool ended = false;
    std::thread thread;
  };
  /// Which rigs jobs may name here.
  struct Rigs {
    std::vector<std::string> ask_for;      ///< benches for which this server asks the lab
    std::vector<std::string> not_without;  ///< benches, and other members' simulators
  };

  void Main();
  void Look();
  std::optional<Steady> NextLook();
  void Reap();
  void JoinEnded();
  void StopLost();
  Rigs RigsNow() const;
  void AskForBenches(const Rigs& rigs);
  core::Result<lab::TicketRequest> TicketFor(const Job& job, const lab::LabState& state);
  void BeginOnBenches();
  void BeginInPlaces(const Rigs& rigs);
  JobsLeftOut LeftOut(const Rigs& rigs);
  void Begin(Job job, std::string bench);
  bool IsPutOff(const std::string& job) const;
  enum class Needs { kAnyRig, kBench };
  void PutOff(const Job& job, Needs needs);

  // On the thread of the job.
  void Do(InProgress& it);
  /// The account that owns the job, in its present state. nullopt: deleted or disabled.
  std::optional<Principal> OwnerOf(const Job& job) const;
  void DoDiagnosis(const Job& job, const Principal& who, const DiagnosisRequest& request);
  void DoMethods(const Job& job, const Principal& who, const MethodsRequest& request);
  void DoRun(InProgress& it, const Principal& who, ExperimentPlan plan);
  void AwaitTurn(const Job& job);
  bool OthersAwaitTurn(const std::string& owner) const;
  void Follow(InProgress& it, const std::string& run);
  void FinishByRun(const InProgress& it);
  void FinishLost(const Job& job, const std::string& error);
  void Finish(const Job& job, const std::string& state, const std::string& error);
  void Drop(const std::string& job);
  /// The session in which a job is; null when it has none.
  static const lab::Session* SessionOf(const lab::LabState& state, const std::string& job);
  bool stopping() const;
  template <typename T>
  void Log(const core::Result<T>& done) const {
    if (!done.ok()) options_.log("jobs: " + done.error().message);
  }

  static constexpr const char* kServerStops = "the server stops";

  const Parts parts_;
  const Options options_;
  mutable std::mutex mutex_;
  bool stopping_ = false;
  std::list<InProgress> in_progress_;
  struct WhenAgain {
    std::string owner;
    Steady at;
    Needs needs;
  };
  std::map<std::string, WhenAgain> put_off_;  ///< jobs that found no rig
  /// Jobs that found the turn of long recordings taken, and their owners, until it is free.
  std::map<std::string, std::string> await_turn_;
  /// Owners who have given that turn up, until another's job has begun, or none can.
  std::set<std::string> gave_way_;
  bool retry_ = false;  ///< the database or the lab did not answer
  Steady reaped_{};
  std::thread thread_;
};

}  // namespace faultlab::server
