#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/clock.h"
#include "server/jobs/job_store.h"
#include "server/lab/lab_service.h"
#include "server/storage/recording_store.h"

namespace faultlab::tests {

/// How far a process of the server has come: the step and the second of the day. Survives the kill.
struct Progress {
  int step = 0;
  int second = 0;
};

/// One scripted day of a lab with two benches and a simulator, on the real service, stores and
/// disk: every transition of the state machines happens at a known second. Each step makes a
/// request and repeats it if necessary, as people do after an error, so that a day that was cut
/// anywhere can continue with the step that was cut. Throws std::runtime_error when a step does not
/// reach its goal.
class CrashDay {
 public:
  /// The start of a server: marks cut runs, gives jobs back, opens the lab (which checks its rigs
  /// anew). `note` is called at every step and every advance of the clock.
  CrashDay(server::Database& database, Progress from, std::function<void(Progress)> note);

  static int steps();
  static std::string NameOf(int step);
  /// Lets the checks pass that the restart requested.
  void PassChecks();
  void Run(int step);
  const server::lab::LabService& service() const { return *service_; }

 private:
  class Bench : public server::lab::RigDuties {
   public:
    void Fence(const server::lab::RigId&, std::uint64_t) override {}
    void StartCleaning(const server::lab::Lease&) override {}
    bool RunInProgress(const server::lab::RigId& rig) override {
      return running && rig == "bench-1";
    }
    std::atomic<bool> running{false};
  };
  struct NamedStep {
    int second;
    const char* name;
    void (*act)(CrashDay&);
  };
  static const std::vector<NamedStep>& Script();

  using Scheduler = server::lab::Scheduler;
  using LabState = server::lab::LabState;
  void At(int second);
  void Tick();
  void TickUntil(const std::function<bool()>& reached, const std::string& what);
  void Want(bool reached, const std::string& what) const;
  std::shared_ptr<const LabState> state() const { return service_->state(); }
  const server::lab::Session* SessionOf(const LabState& state, int user) const;
  const server::lab::Ticket* TicketOf(const LabState& state, int user) const;
  const server::lab::Booking* BookingOf(const LabState& state, int user) const;
  bool Has(int user, server::lab::SessionState wanted) const;
  server::lab::RigStatus StatusOf(const std::string& rig) const;

  void RigsCome();
  void Ask(int user, const std::string& rig_class = "bench");
  void Accept(int user);
  void Leave(int user);
  void Act(int user);
  void Extend(int user, int until);  ///< the session ends later than at second `until`
  void End(int user);
  void OfferControl(int user, int to);
  void AcceptControl(int user, int from);
  void TakeOver(int teacher, int user);
  void Book(int user, int from, int to);
  void Cancel(int user);
  void Claim(int user);
  void AddOutage(const std::string& rig, int from, int to);
  void RemoveOutages();
  void QuarantineRigOf(int user);
  void Release(const std::string& rig);
  void FailCheck(const std::string& rig);
  void LetCheckTimeOut(const std::string& rig, int second);
  void GoOffline(const std::string& rig);
  void GoOnline(const std::string& rig);
  void AskForJob(int user, const std::string& job);
  void EndJobSession(const std::string& job);
  void StartRun();
  void RecordRun();
  void FinishRun();
  void AddJobs();
  void ClaimJob(const std::string& id);
  void GiveJobBack(const std::string& id);
  void FinishJob(const std::string& id);
  void CancelJob(const std::string& id);

  server::ManualClock clock_;
  Bench bench_;
  server::JobStore jobs_;
  server::RecordingStore recordings_;
  std::unique_ptr<server::lab::LabService> service_;
  std::function<void(Progress)> note_;
  Progress progress_;
  std::string run_;
};

}  // namespace faultlab::tests
