#include "server/app/job_runner.h"

#include <boost/json.hpp>

#include "server/api/diagnose_job.h"
#include "server/api/handlers.h"
#include "server/api/run_body.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kIdle{500};
constexpr milliseconds kLease = seconds(60);
constexpr milliseconds kPoll{200};
/// A job without a rig is looked at again after this; others have their turn meanwhile.
constexpr milliseconds kNextLook = seconds(1);
/// Arming, the way to the first sample and the end of the recording, on top of the run itself.
constexpr milliseconds kMargin = seconds(30);

}  // namespace

JobRunner::JobRunner(ApiContext& api, LabApi& lab, Options options)
    : api_(api), lab_(lab), options_(std::move(options)) {
  for (int i = 0; i < options_.workers; ++i) {
    threads_.emplace_back([this] { Loop(); });
  }
}

JobRunner::~JobRunner() {
  Stop();
}

void JobRunner::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

bool JobRunner::WaitForStop(milliseconds patience) {
  std::unique_lock lock(mutex_);
  return wake_.wait_for(lock, patience, [&] { return stopping_; });
}

void JobRunner::Loop() {
  while (true) {
    const WallTime now = api_.clock.Wall();
    Log(lab_.jobs.Reap(now, ""));
    const auto job = lab_.jobs.Claim(options_.server_id, now, now + kLease);
    Log(job);
    if (job.ok() && job.value()) {
      Do(*job.value());
      if (WaitForStop(milliseconds(0))) return;
    } else if (WaitForStop(kIdle)) {
      return;
    }
  }
}

void JobRunner::Finish(const lab::Job& job, const std::string& state, const std::string& error) {
  Log(lab_.jobs.Finish(job, state, error, api_.clock.Wall()));
}

/// If this fails, the job waits again when its lease runs out.
void JobRunner::GiveBack(const lab::Job& job) {
  Log(lab_.jobs.GiveBack(job, api_.clock.Wall() + kNextLook));
}

std::optional<Principal> JobRunner::OwnerOf(const lab::Job& job) const {
  const auto account = lab_.accounts.Get(job.account_id);
  if (!account.ok() || account.value().disabled) return std::nullopt;
  Principal who;
  who.user_id = account.value().id;
  who.login = account.value().login;
  who.name = account.value().name;
  who.role = account.value().role;
  return who;
}

void JobRunner::Do(const lab::Job& job) {
  const std::optional<Principal> who = OwnerOf(job);
  if (!who) {
    Finish(job, "failed", "its account is gone or disabled");
  } else if (json::parse(job.body).as_object().contains("diagnose")) {
    Diagnose(job, *who);
  } else {
    Run(job, *who);
  }
}

void JobRunner::Diagnose(const lab::Job& job, const Principal& who) {
  const auto parsed = ParseDiagnoseJob(json::parse(job.body).as_object());
  const core::Result<std::string> result =
      parsed.ok() ? RunDiagnoseJob(api_, who, *parsed.value()) : parsed.error();
  if (!result.ok()) return Finish(job, "failed", result.error().message);
  const core::Status kept = lab_.jobs.SetResult(job, result.value());
  Finish(job, kept.ok() ? "finished" : "failed", kept.ok() ? "" : kept.error().message);
}

core::Result<std::optional<std::string>> JobRunner::RigFor(const lab::Job& job,
                                                           const std::string& wanted,
                                                           double duration_s) {
  using MaybeRig = std::optional<std::string>;
  const auto state = lab_.service.state();
  const auto known = state->rigs.find(wanted);
  if (known == state->rigs.end() || known->second.elastic) return MaybeRig{wanted};
  lab::TicketRequest request;
  request.user = lab::UserId{job.account_id};
  request.rig_class = known->second.rig_class;
  request.kind = lab::TicketKind::kJob;
  request.job = job.id;
  request.weight = lab_.service.policy().job_weight_s;
  request.min = request.want =
      std::chrono::ceil<milliseconds>(std::chrono::duration<double>(duration_s)) + kMargin;
  const auto answer = lab_.service.Do([&](lab::Scheduler& scheduler, WallTime now) {
    return scheduler.RequestTicket(request, now);
  });
  if (!answer.ok()) {
    if (answer.error().code == core::ErrorCode::kBusy) return MaybeRig{};
    return answer.error();
  }
  const auto* session = std::get_if<lab::Session>(&answer.value());
  if (session == nullptr || session->state != lab::SessionState::kActive) return MaybeRig{};
  // The rig of another server: that one takes the job at its next look.
  const auto member = lab_.service.MemberOf(session->rig);
  if (!member || member->id != options_.server_id) return MaybeRig{};
  return MaybeRig{session->rig};
}

void JobRunner::Run(const lab::Job& job, const Principal& who) {
  const auto parsed = ParseRunBody(job.body, api_.default_seed);
  if (!parsed.ok()) return Finish(job, "failed", parsed.error().message);
  const auto rig = RigFor(job, parsed.value().rig, parsed.value().duration_s);
  if (!rig.ok()) return Finish(job, "failed", rig.error().message);
  if (!rig.value()) {
    return GiveBack(job);
  }
  const auto rigs = lab_.service.state()->rigs;
  const auto leased = rigs.find(*rig.value());
  const bool in_session = leased != rigs.end() && !leased->second.elastic;
  json::object body = json::parse(job.body).as_object();
  if (!rig.value()->empty()) body["rig"] = *rig.value();
  const std::string text = json::serialize(body);
  HttpRequest http;
  http.method = HttpMethod::kPost;
  http.path = "/api/v1/runs";
  http.target = http.path;
  http.body = text;
  const auto answer = CreateRun(api_, {http, who});
  if (!answer.ok() && answer.error().code == core::ErrorCode::kBusy) {
    return GiveBack(job);
  }
  if (answer.ok()) {
    Follow(job, std::string(json::parse(answer.value().body).at("id").as_string()));
  } else {
    Finish(job, "failed", answer.error().message);
  }
  // A server that stops leaves the session to its job.
  if (!in_session || WaitForStop(milliseconds(0))) return;
  Log(lab_.service.Do(
      [&](lab::Scheduler& scheduler, WallTime now) { return scheduler.DropJob(job.id, now); }));
}

void JobRunner::Follow(const lab::Job& job, const std::string& run) {
  Log(lab_.jobs.SetRun(job, run));
  for (auto live = api_.runs.Find(run); live && live->state == RunState::kRunning;
       live = api_.runs.Find(run)) {
    // Stopping the server stops the run; its job waits for the next start.
    if (WaitForStop(kPoll)) return;
    Log(lab_.jobs.Renew(job, api_.clock.Wall() + kLease));
  }
  api_.runs.Wait(run);
  const auto record = api_.store.Get(run);
  const bool finished = record.ok() && record.value().state == RunState::kFinished;
  const std::string state(record.ok() ? Name(record.value().state) : "lost");
  Finish(job, finished ? "finished" : "failed", finished ? "" : "its run ended as " + state);
}

}  // namespace faultlab::server
