#include "tests/server/lab/crash_day.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "server/lab/scheduler.h"

namespace faultlab::tests {
namespace {

using namespace server::lab;  // NOLINT: shorter names keep the script readable
using core::Done;
using core::Status;
using server::Job;
using server::RunRecord;
using server::RunState;
using server::WallTime;
using std::chrono::seconds;

constexpr const char* kServer = "crash-day";

// The people of the day.
constexpr int kAnn = 1, kBob = 2, kCem = 3, kDan = 4, kEve = 5, kFay = 6, kGus = 7, kHal = 8,
              kIda = 9, kKay = 10, kLou = 11, kMia = 12, kRobot = 13, kTeacher = 20;

WallTime InstantOf(int second) {
  static const WallTime morning = server::ManualClock{}.Wall();
  return morning + seconds(second);
}

}  // namespace

CrashDay::CrashDay(server::Database& database, Progress from, std::function<void(Progress)> note)
    : jobs_(database), recordings_(database), note_(std::move(note)), progress_(from) {
  clock_.Advance(seconds(from.second));
  LabServiceOptions options;
  options.member = kServer;
  options.tick = std::chrono::hours(1);  // the script advances the time
  auto opened = LabService::Open(database, clock_, bench_, options);
  Want(opened.ok(), opened.ok() ? "" : "the lab opens: " + opened.error().message);
  service_ = std::move(opened).value();
  Want(jobs_.Reap(clock_.Wall()).ok(), "jobs are given back");
}

void CrashDay::Want(bool reached, const std::string& what) const {
  if (reached) return;
  throw std::runtime_error("step " + std::to_string(progress_.step) + " (" +
                           NameOf(progress_.step) + "), second " +
                           std::to_string(progress_.second) + ": not so: " + what);
}

void CrashDay::At(int second) {
  if (second <= progress_.second) return;
  clock_.Advance(seconds(second - progress_.second));
  progress_.second = second;
  note_(progress_);
}

void CrashDay::Run(int step) {
  const NamedStep& now = Script()[static_cast<std::size_t>(step)];
  progress_.step = step;
  note_(progress_);
  At(now.second);
  now.act(*this);
  Want(FindBrokenInvariant(*state()).empty(), FindBrokenInvariant(*state()));
}

int CrashDay::steps() {
  return static_cast<int>(Script().size());
}

std::string CrashDay::NameOf(int step) {
  return Script()[static_cast<std::size_t>(step)].name;
}

void CrashDay::Tick() {
  Want(service_->TickNow().ok(), "time passes");
}

void CrashDay::TickUntil(const std::function<bool()>& reached, const std::string& what) {
  // A restart begins offers and holds anew, so a transition caused by time may come later.
  for (int tries = 0; tries < 20 && !reached(); ++tries) {
    if (tries > 0) At(progress_.second + 15);
    Tick();
  }
  Want(reached(), what);
}

void CrashDay::PassChecks() {
  const auto before = state();
  for (const auto& [id, rig] : before->rigs) {
    if (rig.status != RigStatus::kCleaning) continue;
    Want(service_->CleaningDone(id, rig.epoch, true, "").ok(), "the check of " + id + " passes");
  }
}

const Session* CrashDay::SessionOf(const LabState& state, int user) const {
  for (const auto& [id, session] : state.sessions) {
    const bool live = session.state != SessionState::kClosed;
    if (live && session.user == UserId{user} && session.kind == TicketKind::kPerson)
      return &session;
  }
  return nullptr;
}

const Ticket* CrashDay::TicketOf(const LabState& state, int user) const {
  for (const auto& [id, ticket] : state.tickets) {
    if (ticket.user == UserId{user} && ticket.kind == TicketKind::kPerson) return &ticket;
  }
  return nullptr;
}

const Booking* CrashDay::BookingOf(const LabState& state, int user) const {
  for (const auto& [id, booking] : state.bookings) {
    if (booking.user == UserId{user}) return &booking;
  }
  return nullptr;
}

bool CrashDay::Has(int user, SessionState wanted) const {
  const auto now = state();
  const Session* session = SessionOf(*now, user);
  return session != nullptr && session->state == wanted;
}

server::lab::RigStatus CrashDay::StatusOf(const std::string& rig) const {
  return state()->rigs.at(rig).status;
}

void CrashDay::RigsCome() {
  (void)service_->Do([](Scheduler& lab, WallTime now) -> Status {
    for (const char* rig : {"bench-1", "bench-2", "sim-1"}) {
      const bool elastic = std::string(rig) == "sim-1";
      (void)lab.AddRig(rig, elastic ? "sim" : "bench", elastic);
      (void)lab.Claim(rig, kServer, now);
    }
    return Done{};
  });
  Want(StatusOf("sim-1") != RigStatus::kOffline, "the rigs are checked");
}

void CrashDay::Ask(int user, const std::string& rig_class) {
  const auto answer = service_->Do([&](Scheduler& lab, WallTime now) {
    TicketRequest request;
    request.user = UserId{user};
    request.rig_class = rig_class;
    return lab.RequestTicket(request, now);
  });
  Want(answer.ok(), "a place in the queue");
}

void CrashDay::Accept(int user) {
  const auto before = state();
  if (const Ticket* ticket = TicketOf(*before, user)) {
    (void)service_->Do([&](Scheduler& lab, WallTime now) {
      return lab.AcceptTicket(ticket->id, UserId{user}, now);
    });
  }
  Want(Has(user, SessionState::kActive), "the session runs");
}

void CrashDay::Leave(int user) {
  const auto before = state();
  if (const Ticket* ticket = TicketOf(*before, user)) {
    (void)service_->Do(
        [&](Scheduler& lab, WallTime now) { return lab.LeaveTicket(ticket->id, now); });
  }
  Want(TicketOf(*state(), user) == nullptr, "the ticket is gone");
}

void CrashDay::Act(int user) {
  const auto before = state();
  const Session* session = SessionOf(*before, user);
  Want(session != nullptr, "a session to act in");
  const Status done = service_->Do([&](Scheduler& lab, WallTime now) {
    return lab.ControlActivity(session->id, session->epoch, now);
  });
  Want(done.ok(), "the command counts as activity");
}

void CrashDay::Extend(int user, int until) {
  const auto before = state();
  const Session* session = SessionOf(*before, user);
  Want(session != nullptr, "a session to extend");
  const auto longer =
      service_->Do([&](Scheduler& lab, WallTime now) { return lab.Extend(session->id, now); });
  if (!longer.ok()) {  // after a kill, the extension that this step asks for may be stored already
    Want(longer.error().reason == "extend_early", longer.error().message);
  }
  Want(SessionOf(*state(), user)->hard_end > InstantOf(until), "the session is longer");
}

void CrashDay::End(int user) {
  const auto before = state();
  if (const Session* session = SessionOf(*before, user)) {
    (void)service_->Do([&](Scheduler& lab, WallTime now) {
      return lab.EndSession(session->id, EndReason::kEnded, "ended", now);
    });
  }
  Want(SessionOf(*state(), user) == nullptr, "the session is over");
}

void CrashDay::OfferControl(int user, int to) {
  const auto before = state();
  const Session* session = SessionOf(*before, user);
  Want(session != nullptr, "a session to offer");
  (void)service_->Do(
      [&](Scheduler& lab, WallTime now) { return lab.OfferControl(session->id, UserId{to}, now); });
  Want(SessionOf(*state(), user)->offered_to == UserId{to}, "the control is offered");
}

void CrashDay::AcceptControl(int user, int from) {
  const auto before = state();
  if (const Session* session = SessionOf(*before, from)) {
    (void)service_->Do([&](Scheduler& lab, WallTime now) {
      return lab.AcceptControl(session->id, UserId{user}, now);
    });
  }
  Want(Has(user, SessionState::kActive) && SessionOf(*state(), from) == nullptr,
       "the control has changed hands");
}

void CrashDay::TakeOver(int teacher, int user) {
  const auto before = state();
  if (const Session* session = SessionOf(*before, user)) {
    (void)service_->Do([&](Scheduler& lab, WallTime now) {
      return lab.TakeOver(session->id, UserId{teacher}, "smoke", now);
    });
  }
  Want(Has(teacher, SessionState::kActive), "the teacher has the control");
}

void CrashDay::Book(int user, int from, int to) {
  (void)service_->Do([&](Scheduler& lab, WallTime now) {
    return lab.Book(UserId{user}, "bench", {InstantOf(from), InstantOf(to)}, now, {}, true);
  });
  Want(BookingOf(*state(), user) != nullptr, "the booking stands");
}

void CrashDay::Cancel(int user) {
  const auto before = state();
  if (const Booking* booking = BookingOf(*before, user)) {
    (void)service_->Do([&](Scheduler& lab, WallTime now) {
      return lab.CancelBooking(booking->id, booking->version, now);
    });
  }
  Want(BookingOf(*state(), user) == nullptr, "the booking is gone");
}

void CrashDay::Claim(int user) {
  const auto before = state();
  const Booking* booking = BookingOf(*before, user);
  Want(booking != nullptr, "a booking to claim");
  (void)service_->Do([&](Scheduler& lab, WallTime now) {
    return lab.ClaimBooking(booking->id, UserId{user}, now);
  });
  Want(Has(user, SessionState::kActive), "the booked session runs");
}

void CrashDay::AddOutage(const std::string& rig, int from, int to) {
  const auto there = [&] {
    const auto now = state();
    return std::any_of(now->outages.begin(), now->outages.end(), [&](const auto& outage) {
      return outage.second.rig == rig;
    });
  };
  if (!there()) {
    (void)service_->Do([&](Scheduler& lab, WallTime now) {
      return lab.AddOutage(rig, {InstantOf(from), InstantOf(to)}, "new brushes", now);
    });
  }
  Want(there(), "the outage is planned");
}

void CrashDay::RemoveOutages() {
  const auto before = state();
  for (const auto& [id, outage] : before->outages) {
    (void)service_->Do(
        [&, key = id](Scheduler& lab, WallTime now) { return lab.RemoveOutage(key, now); });
  }
  Want(state()->outages.empty(), "no outage is left");
}

void CrashDay::QuarantineRigOf(int user) {
  const auto before = state();
  if (const Session* session = SessionOf(*before, user)) {
    (void)service_->Do(
        [&](Scheduler& lab, WallTime now) { return lab.Quarantine(session->rig, "smells", now); });
  }
  Want(SessionOf(*state(), user) == nullptr, "the session fell with its rig");
}

void CrashDay::Release(const std::string& rig) {
  if (StatusOf(rig) == RigStatus::kQuarantined) {
    (void)service_->Do([&](Scheduler& lab, WallTime now) { return lab.Release(rig, now); });
  }
  const RigStatus status = StatusOf(rig);
  Want(status == RigStatus::kCleaning || status == RigStatus::kReady, rig + " comes back");
}

void CrashDay::FailCheck(const std::string& rig) {
  if (StatusOf(rig) == RigStatus::kReady) {
    (void)service_->Do([&](Scheduler& lab, WallTime now) { return lab.Recheck(rig, now); });
  }
  if (StatusOf(rig) == RigStatus::kCleaning) {
    (void)service_->CleaningDone(rig, state()->rigs.at(rig).epoch, false, "gain is 0.4");
  }
  Want(StatusOf(rig) == RigStatus::kQuarantined, rig + " is not handed on");
}

void CrashDay::LetCheckTimeOut(const std::string& rig, int second) {
  if (StatusOf(rig) == RigStatus::kReady) {
    (void)service_->Do([&](Scheduler& lab, WallTime now) { return lab.Recheck(rig, now); });
  }
  At(second);
  Tick();
  if (StatusOf(rig) == RigStatus::kCleaning) {  // a restart has begun the check anew
    At(second + 121);
    Tick();
  }
  Want(StatusOf(rig) == RigStatus::kQuarantined, rig + " is not handed on");
}

void CrashDay::GoOffline(const std::string& rig) {
  (void)service_->Do(
      [&](Scheduler& lab, WallTime now) { return lab.RigOffline(rig, "no answer", now); });
  Want(StatusOf(rig) == RigStatus::kOffline, rig + " is offline");
}

void CrashDay::GoOnline(const std::string& rig) {
  (void)service_->Do([&](Scheduler& lab, WallTime now) { return lab.Claim(rig, kServer, now); });
  Want(StatusOf(rig) != RigStatus::kOffline, rig + " is back");
}

void CrashDay::AskForJob(int user, const std::string& job) {
  const auto answer = service_->Do([&](Scheduler& lab, WallTime now) {
    TicketRequest request;
    request.user = UserId{user};
    request.rig_class = "bench";
    request.kind = TicketKind::kJob;
    request.job = job;
    request.min = request.want = seconds(60);
    return lab.RequestTicket(request, now);
  });
  Want(answer.ok(), "the job has a place or a rig");
}

void CrashDay::EndJobSession(const std::string&) {
  const auto before = state();
  for (const auto& [id, session] : before->sessions) {
    if (session.kind != TicketKind::kJob) continue;
    (void)service_->Do([&, key = id](Scheduler& lab, WallTime now) {
      return lab.EndSession(key, EndReason::kEnded, "the job's run is done", now);
    });
  }
  const auto after = state();
  Want(std::none_of(after->sessions.begin(),
                    after->sessions.end(),
                    [](const auto& entry) { return entry.second.kind == TicketKind::kJob; }),
       "the job has left its rig");
}

void CrashDay::StartRun() {
  RunRecord record;
  record.id = "run-" + std::to_string(progress_.second);
  record.owner = "user:1";
  record.rig = "bench-1";
  record.source = "run";
  record.server_id = kServer;
  record.created_at = clock_.Wall();
  core::Status begun = recordings_.Begin(record);
  while (!begun.ok() && begun.error().code == core::ErrorCode::kConflict) {
    record.id += "-again";  // a process was killed here before
    begun = recordings_.Begin(record);
  }
  Want(begun.ok(), begun.ok() ? "" : "the recording begins: " + begun.error().message);
  run_ = record.id;
  bench_.running = true;
  Tick();
  Want(SessionOf(*state(), kAnn)->run_in_progress, "the run is known");
}

void CrashDay::RecordRun() {
  if (run_.empty()) return;  // the kill ended the run; its user sees that it was interrupted
  std::vector<core::Sample> samples(100);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i].index = static_cast<std::int64_t>(i);
  Want(recordings_.AppendChunk(run_, 0, samples).ok(), "a second of samples is stored");
}

void CrashDay::FinishRun() {
  if (run_.empty()) return;
  Want(recordings_.Finish(run_, RunState::kFinished, clock_.Wall(), "{}", "nominal").ok(),
       "the run is stored");
  bench_.running = false;
  Tick();
  Want(!SessionOf(*state(), kAnn)->run_in_progress, "the run is over");
}

void CrashDay::AddJobs() {
  if (!jobs_.Get("job-1").ok()) {
    std::vector<Job> jobs;
    for (const char* id : {"job-1", "job-2", "job-3"}) {
      Job job;
      job.id = id;
      job.owner = "user:13";
      job.account_id = kRobot;
      job.body = "{}";
      job.created_at = InstantOf(0) + std::chrono::milliseconds(jobs.size());
      jobs.push_back(job);
    }
    (void)jobs_.Add(jobs);
  }
  for (const char* id : {"job-1", "job-2", "job-3"}) Want(jobs_.Get(id).ok(), "all jobs stand");
}

void CrashDay::ClaimJob(const std::string& id) {
  if (jobs_.Get(id).value().state == "waiting") {
    (void)jobs_.Claim({kServer, service_->boot()}, {}, clock_.Wall());
    (void)jobs_.SetRun(jobs_.Get(id).value(), "run-of-" + id);
  }
  Want(jobs_.Get(id).value().state == "running", id + " runs");
}

void CrashDay::GiveJobBack(const std::string& id) {
  (void)jobs_.GiveBack(jobs_.Get(id).value());
  Want(jobs_.Get(id).value().state == "waiting", id + " waits again");
}

void CrashDay::FinishJob(const std::string& id) {
  if (jobs_.Get(id).value().state != "finished") {
    ClaimJob(id);
    (void)jobs_.Finish(jobs_.Get(id).value(), "finished", "", clock_.Wall());
  }
  Want(jobs_.Get(id).value().state == "finished", id + " is done");
}

void CrashDay::CancelJob(const std::string& id) {
  (void)jobs_.Cancel(id, clock_.Wall());
  Want(jobs_.Get(id).value().state == "cancelled", id + " is cancelled");
}

const std::vector<CrashDay::NamedStep>& CrashDay::Script() {
  using Day = CrashDay;
  static const std::vector<NamedStep> kScript = {
      {0, "rigs come", [](Day& d) { d.RigsCome(); }},
      {1, "the first checks pass", [](Day& d) { d.PassChecks(); }},
      {10, "ann asks", [](Day& d) { d.Ask(kAnn); }},
      {12, "ann accepts", [](Day& d) { d.Accept(kAnn); }},
      {14, "bob asks", [](Day& d) { d.Ask(kBob); }},
      {16, "bob accepts", [](Day& d) { d.Accept(kBob); }},
      {20, "cem asks and waits", [](Day& d) { d.Ask(kCem); }},
      {22, "dan asks and waits", [](Day& d) { d.Ask(kDan); }},
      {30, "ann's run starts", [](Day& d) { d.StartRun(); }},
      {31, "a second of it is stored", [](Day& d) { d.RecordRun(); }},
      {60, "ann's run ends", [](Day& d) { d.FinishRun(); }},
      {70, "ann offers the control to eve", [](Day& d) { d.OfferControl(kAnn, kEve); }},
      {72, "eve accepts the control", [](Day& d) { d.AcceptControl(kEve, kAnn); }},
      {80, "the teacher takes over", [](Day& d) { d.TakeOver(kTeacher, kEve); }},
      {90, "the teacher ends", [](Day& d) { d.End(kTeacher); }},
      {95, "the rig goes to cem", [](Day& d) { d.PassChecks(); }},
      {141, "cem misses the offer", [](Day& d) { d.Tick(); }},
      {187,
       "cem misses again, dan is next",
       [](Day& d) {
         d.TickUntil([&] { return d.TicketOf(*d.state(), kCem) == nullptr; }, "cem is out");
       }},
      {190, "dan accepts", [](Day& d) { d.Accept(kDan); }},
      {195, "fay asks and waits", [](Day& d) { d.Ask(kFay); }},
      {200, "bob is asked whether he is there", [](Day& d) { d.Tick(); }},
      {205, "bob is there", [](Day& d) { d.Act(kBob); }},
      {370, "dan works", [](Day& d) { d.Act(kDan); }},
      {390, "bob is asked again", [](Day& d) { d.Tick(); }},
      {451,
       "bob is gone, his rig is checked",
       [](Day& d) {
         d.TickUntil([&] { return d.SessionOf(*d.state(), kBob) == nullptr; }, "bob is out");
       }},
      {455, "the rig goes to fay", [](Day& d) { d.PassChecks(); }},
      {460, "fay accepts", [](Day& d) { d.Accept(kFay); }},
      {2340, "sessions go on while nobody waits", [](Day& d) { d.Tick(); }},
      {2345, "dan works on", [](Day& d) { d.Act(kDan); }},
      {2346, "fay works on", [](Day& d) { d.Act(kFay); }},
      {2520, "dan works on", [](Day& d) { d.Act(kDan); }},
      {2521, "fay works on", [](Day& d) { d.Act(kFay); }},
      {2595, "dan works on, his session is extended", [](Day& d) { d.Act(kDan); }},
      {2598, "gus asks and waits", [](Day& d) { d.Ask(kGus); }},
      {2601, "fay is warned: 5 minutes", [](Day& d) { d.Tick(); }},
      {2690, "dan works on", [](Day& d) { d.Act(kDan); }},
      {2691, "fay works on", [](Day& d) { d.Act(kFay); }},
      {2841, "fay is warned: 1 minute", [](Day& d) { d.Tick(); }},
      {2860, "dan works on", [](Day& d) { d.Act(kDan); }},
      {2861, "fay works on", [](Day& d) { d.Act(kFay); }},
      {2871, "fay is warned: 30 seconds", [](Day& d) { d.Tick(); }},
      {2901,
       "fay's time is over",
       [](Day& d) {
         d.TickUntil([&] { return d.SessionOf(*d.state(), kFay) == nullptr; }, "fay is out");
       }},
      {2905, "the rig goes to gus", [](Day& d) { d.PassChecks(); }},
      {2910, "gus declines", [](Day& d) { d.Leave(kGus); }},
      {2915, "dan ends", [](Day& d) { d.End(kDan); }},
      {2920, "the rig is ready again", [](Day& d) { d.PassChecks(); }},
      {3000, "hal books", [](Day& d) { d.Book(kHal, 3600, 5400); }},
      {3001, "ida books", [](Day& d) { d.Book(kIda, 3600, 5400); }},
      {3002, "mia books", [](Day& d) { d.Book(kMia, 7200, 9000); }},
      {3003, "mia cancels", [](Day& d) { d.Cancel(kMia); }},
      {3600, "both bookings are due", [](Day& d) { d.Tick(); }},
      {3610, "hal claims", [](Day& d) { d.Claim(kHal); }},
      {3781, "ida does not come", [](Day& d) { d.Tick(); }},
      {3790, "kay books", [](Day& d) { d.Book(kKay, 7200, 8400); }},
      {3791, "lou books", [](Day& d) { d.Book(kLou, 7200, 8400); }},
      {3800,
       "an outage is planned, one booking falls",
       [](Day& d) { d.AddOutage("bench-2", 7000, 8450); }},
      {3900, "hal's rig is quarantined", [](Day& d) { d.QuarantineRigOf(kHal); }},
      {4000, "bench-1 is released", [](Day& d) { d.Release("bench-1"); }},
      {4010, "bench-1 fails its check", [](Day& d) { d.FailCheck("bench-1"); }},
      {4020, "bench-1 is released again", [](Day& d) { d.Release("bench-1"); }},
      {4030, "bench-1 passes", [](Day& d) { d.PassChecks(); }},
      {4300, "bench-2 does not answer", [](Day& d) { d.GoOffline("bench-2"); }},
      {4310, "bench-2 answers", [](Day& d) { d.GoOnline("bench-2"); }},
      {4320, "bench-2 passes", [](Day& d) { d.PassChecks(); }},
      {4400, "a check hangs", [](Day& d) { d.LetCheckTimeOut("bench-1", 4525); }},
      {4700, "bench-1 comes back", [](Day& d) { d.Release("bench-1"); }},
      {4710, "bench-1 passes again", [](Day& d) { d.PassChecks(); }},
      {5000, "mia practises at once", [](Day& d) { d.Ask(kMia, "sim"); }},
      {5010, "mia ends", [](Day& d) { d.End(kMia); }},
      {5020, "the simulator is checked", [](Day& d) { d.PassChecks(); }},
      {5100, "a job takes a gap", [](Day& d) { d.AskForJob(kRobot, "job-9"); }},
      {5110, "the job leaves", [](Day& d) { d.EndJobSession("job-9"); }},
      {5120, "its rig is checked", [](Day& d) { d.PassChecks(); }},
      {6000, "jobs come", [](Day& d) { d.AddJobs(); }},
      {6001, "the first is claimed", [](Day& d) { d.ClaimJob("job-1"); }},
      {6002, "there is no rig for it", [](Day& d) { d.GiveJobBack("job-1"); }},
      {6003, "the first is done", [](Day& d) { d.FinishJob("job-1"); }},
      {6004, "the second is done", [](Day& d) { d.FinishJob("job-2"); }},
      {6005, "the third is cancelled", [](Day& d) { d.CancelJob("job-3"); }},
      {7001, "the outage begins", [](Day& d) { d.Tick(); }},
      {7200, "the booking that stands is due", [](Day& d) { d.Tick(); }},
      {7210,
       "it is claimed",
       [](Day& d) { d.Claim(d.BookingOf(*d.state(), kKay) != nullptr ? kKay : kLou); }},
      {8150,
       "it is extended",
       [](Day& d) { d.Extend(d.BookingOf(*d.state(), kKay) != nullptr ? kKay : kLou, 8400); }},
      {8160,
       "it ends",
       [](Day& d) {
         d.End(kKay);
         d.End(kLou);
       }},
      {8170, "bench-1 is ready", [](Day& d) { d.PassChecks(); }},
      {8460, "the outage is over", [](Day& d) { d.Tick(); }},
      {8470, "bench-2 is checked and ready", [](Day& d) { d.PassChecks(); }},
      {8500, "another outage is planned", [](Day& d) { d.AddOutage("bench-1", 9000, 9600); }},
      {8510, "and called off", [](Day& d) { d.RemoveOutages(); }},
      {8520, "dan books", [](Day& d) { d.Book(kDan, 9600, 10'200); }},
      {8521, "gus books", [](Day& d) { d.Book(kGus, 9600, 10'200); }},
      {8522, "mia waits for that time", [](Day& d) { d.Book(kMia, 9600, 10'200); }},
      {8523, "lou waits, too", [](Day& d) { d.Book(kLou, 9600, 10'200); }},
      {8524, "dan cancels, mia has it", [](Day& d) { d.Cancel(kDan); }},
      {8710, "it is soon, and not for lou", [](Day& d) { d.Tick(); }},
      {9600, "it begins", [](Day& d) { d.Tick(); }},
      {9781, "gus and mia do not come", [](Day& d) { d.Tick(); }},
  };
  return kScript;
}

}  // namespace faultlab::tests
