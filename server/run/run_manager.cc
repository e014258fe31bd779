#include "server/run/run_manager.h"

#include <map>
#include <mutex>
#include <utility>

#include "server/diagnosis_json/options_json.h"
#include "server/run/command_worker.h"
#include "server/run/refusals.h"
#include "server/run/run.h"
#include "server/storage/database_error.h"
#include "server/storage/ids.h"

namespace faultlab::server {
namespace {

core::Error NoRunInProgress() {
  return {core::ErrorCode::kNotFound, "There is no such run in progress.", {}, "run_ended"};
}

constexpr std::size_t kCommandsWaitingMax = 256;

core::Result<hardware::RigCommand> ToRigCommand(const CommandMessage& message,
                                                const core::Bench& bench) {
  hardware::RigCommand command;
  if (message.action != ViewerAction::kSet) return command;
  const auto component = bench.Find(message.component);
  if (!component) return refusal::NoComponent(bench, message.component);
  command.kind = hardware::RigCommand::Kind::kSetComponent;
  command.component = *component;
  command.value = message.value;
  return command;
}

}  // namespace

class RunManager::Impl {
 public:
  Impl(RunManagerOptions options,
       RecordingStore& store,
       StreamHub& hub,
       const Clock& clock,
       std::function<void(std::string_view)> log)
      : options_(std::move(options)),
        store_(store),
        hub_(hub),
        clock_(clock),
        log_(std::move(log)),
        recorder_(store, options_.backlog_folder, options_.room, log_) {}

  core::Result<RunSnapshot> Start(RunRequest request);
  core::Result<Accepted> Obey(const std::string& run, const CommandMessage& message);
  std::shared_ptr<Run> Find(std::string_view id) const;
  void DropEnded();

  RunManagerOptions options_;
  RecordingStore& store_;
  StreamHub& hub_;
  const Clock& clock_;
  std::function<void(std::string_view)> log_;
  RunTap* tap_ = nullptr;
  std::function<bool()> in_force_ = [] { return true; };
  std::function<void(const RunSnapshot&)> owner_stopped_ = [](const RunSnapshot&) {};
  SharedRunCounters counters_;
  Recorder recorder_;
  DiagnosisWorker solver_;
  mutable std::mutex mutex_;
  bool closed_ = false;
  std::map<std::string, std::shared_ptr<Run>, std::less<>> runs_;
  CommandWorker commands_{kCommandsWaitingMax};  ///< destroyed first: it uses the others
};

std::shared_ptr<Run> RunManager::Impl::Find(std::string_view id) const {
  const std::lock_guard lock(mutex_);
  const auto found = runs_.find(id);
  return found == runs_.end() ? nullptr : found->second;
}

void RunManager::Impl::DropEnded() {
  std::vector<std::shared_ptr<Run>> ended;  // joined outside the lock
  const std::lock_guard lock(mutex_);
  for (auto it = runs_.begin(); it != runs_.end();) {
    if (!it->second->ended()) {
      ++it;
      continue;
    }
    ended.push_back(std::move(it->second));
    it = runs_.erase(it);
  }
}

core::Result<RunSnapshot> RunManager::Impl::Start(RunRequest request) {
  DropEnded();
  {
    const std::lock_guard lock(mutex_);
    if (closed_) {
      return core::Refuse("server_stops");
    }
  }

  const hardware::Epoch epoch = request.hold.epoch();
  hardware::Rig& rig = request.hold.rig();
  const hardware::RigDescription& description = rig.description();
  request.diagnosis.period_s = request.plan.period_s;
  const core::Status armed = rig.Arm(request.plan, epoch);
  if (!armed.ok()) return refusal::OfLease(description.id, armed.error());

  RunRecord record;
  record.id = NewId("run");
  record.name = request.name;
  record.owner = request.owner;
  record.rig = description.id;
  record.source = "run";
  record.server_id = options_.server_id;
  record.epoch = static_cast<std::uint64_t>(epoch);
  record.bench = request.diagnosis.bench->id;
  record.period_s = request.plan.period_s;
  record.plan_json = request.plan_json;
  record.options_json = OptionsText(request.diagnosis);
  record.created_at = clock_.Wall();
  record.kept_run = rig.kept_run();
  const core::Status begun = store_.Begin(record);
  if (!begun.ok()) {
    // It may have been stored all the same: the answer is what was lost.
    if (MayPass(begun.error())) recorder_.EndLater(record.id, {RunState::kFailed, clock_.Wall()});
    return begun.error();
  }

  RunServices services{store_,
                       recorder_,
                       solver_,
                       commands_,
                       hub_,
                       clock_,
                       &counters_,
                       tap_,
                       options_.speed,
                       log_,
                       options_.complete,
                       options_.calibrated,
                       options_.moment};
  const std::string id = record.id;
  auto run =
      std::make_shared<Run>(std::move(services),
                            std::move(request),
                            record,
                            [this, id](ViewerId viewer, const CommandMessage& message) {
                              const bool queued = commands_.Submit([this, id, viewer, message] {
                                hub_.Reply(viewer, AckText(message, Obey(id, message)));
                              });
                              if (queued) return;
                              hub_.Reply(viewer, AckText(message, core::Refuse("commands_full")));
                            });
  const core::Status started = run->Start();
  if (!started.ok()) {
    const RunEnd end{RunState::kFailed, clock_.Wall()};
    const core::Status ended = store_.Finish(id, end.state, end.at, "", "");
    if (!ended.ok()) recorder_.EndLater(id, end);
    return started.error();
  }
  ++counters_.started;
  const std::lock_guard lock(mutex_);
  runs_.emplace(id, run);
  return run->Snapshot();
}

core::Result<Accepted> RunManager::Impl::Obey(const std::string& id,
                                              const CommandMessage& message) {
  const std::shared_ptr<Run> run = Find(id);
  if (run == nullptr || run->ended()) {
    return core::Refuse("run_ended");
  }
  if (message.action == ViewerAction::kStop) {
    if (message.epoch != run->epoch()) return core::Refuse("stale_epoch", "epoch");
    run->Stop(kStoppedByOwner);  // nobody else's viewer commands
    owner_stopped_(run->Snapshot());
    return Accepted{};
  }
  if (!in_force_()) return core::Refuse("out_of_touch");
  TRY(const auto command, ToRigCommand(message, run->bench()));
  return run->Command(message.epoch, command);
}

RunManager::RunManager(RunManagerOptions options,
                       RecordingStore& store,
                       StreamHub& hub,
                       const Clock& clock,
                       std::function<void(std::string_view)> log)
    : impl_(std::make_unique<Impl>(std::move(options), store, hub, clock, std::move(log))) {}

RunManager::~RunManager() {
  Shutdown();
}

void RunManager::SetTap(RunTap* tap) {
  impl_->tap_ = tap;
}

void RunManager::SetGuard(std::function<bool()> in_force) {
  impl_->in_force_ = std::move(in_force);
}

void RunManager::OnOwnersStop(std::function<void(const RunSnapshot&)> told) {
  impl_->owner_stopped_ = std::move(told);
}

core::Result<RunSnapshot> RunManager::Start(RunRequest request) {
  return impl_->Start(std::move(request));
}

core::Status RunManager::Stop(std::string_view id, std::string_view reason) {
  const std::shared_ptr<Run> run = impl_->Find(id);
  if (run == nullptr) {
    return NoRunInProgress();
  }
  if (run->ended()) return core::Refuse("run_ended");
  run->Stop(reason);
  return core::Done{};
}

core::Result<Accepted> RunManager::Command(std::string_view id,
                                           hardware::Epoch epoch,
                                           const hardware::RigCommand& command) {
  const std::shared_ptr<Run> run = impl_->Find(id);
  if (run == nullptr) {
    return NoRunInProgress();
  }
  return run->Command(epoch, command);
}

core::Result<Accepted> RunManager::LearnAgain(std::string_view id) {
  const std::shared_ptr<Run> run = impl_->Find(id);
  if (run == nullptr || run->ended()) return core::Refuse("run_ended");
  return run->LearnAgain();
}

std::optional<RunSnapshot> RunManager::Find(std::string_view id) const {
  const std::shared_ptr<Run> run = impl_->Find(id);
  if (run == nullptr) return std::nullopt;
  return run->Snapshot();
}

std::vector<RunSnapshot> RunManager::Running() const {
  impl_->DropEnded();
  std::vector<std::shared_ptr<Run>> all;
  {
    const std::lock_guard lock(impl_->mutex_);
    for (const auto& [id, run] : impl_->runs_) all.push_back(run);
  }
  std::vector<RunSnapshot> out;
  for (const auto& run : all) out.push_back(run->Snapshot());
  return out;
}

void RunManager::Wait(std::string_view id) {
  if (const std::shared_ptr<Run> run = impl_->Find(id)) run->Wait();
}

core::Status RunManager::StoreBacklogs() {
  const std::string& folder = impl_->options_.backlog_folder;
  if (folder.empty()) return core::Done{};
  return server::StoreBacklogs(folder, impl_->store_, impl_->log_);
}

void RunManager::Shutdown() {
  std::vector<std::shared_ptr<Run>> all;
  {
    const std::lock_guard lock(impl_->mutex_);
    impl_->closed_ = true;
    for (const auto& [id, run] : impl_->runs_) all.push_back(run);
  }
  for (const auto& run : all) run->Stop("the server stops");
  impl_->recorder_.Leave(impl_->options_.leave_after);
  for (const auto& run : all) run->Wait();
  all.clear();
  impl_->DropEnded();
}

RunCounters RunManager::counters() const {
  RunCounters out;
  out.started = impl_->counters_.started;
  out.samples = impl_->counters_.samples;
  out.overruns = impl_->counters_.overruns;
  out.gaps = impl_->counters_.gaps;
  for (std::size_t i = 0; i < impl_->counters_.ended.size(); ++i) {
    out.ended[i] = impl_->counters_.ended[i];
  }
  out.solver_tasks = impl_->counters_.solver_tasks;
  return out;
}

}  // namespace faultlab::server
