#include "tests/world/world_member.h"

#include <algorithm>

namespace faultlab::server::lab::rehearsal {
namespace {

using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

/// As RigUpkeep: a check waits so long for the last run to let go.
constexpr WorldTime kRigPatience = seconds(20);
constexpr std::size_t kOldChecksKept = 16;

const core::Bench& AnyBench() {
  static const core::Bench kBench;
  return kBench;
}

/// The start of the next booking or outage on the rig.
WallTime BusyFrom(const LabState& state, const RigId& rig) {
  WallTime next = WallTime::max();
  for (const auto& [id, booking] : state.bookings) {
    if (booking.rig == rig) next = std::min(next, booking.during.start);
  }
  for (const auto& [id, outage] : state.outages) {
    if (outage.rig == rig) next = std::min(next, outage.during.start);
  }
  return next;
}

Principal PrincipalOf(UserId user) {
  Principal who;
  who.user_id = Number(user);
  return who;
}

}  // namespace

WorldMember::WorldMember(Site& site, std::string id, OpenStore open)
    : site_(site), id_(std::move(id)), open_(std::move(open)), clock_(site.now) {
  faults_.told = [this](const std::vector<LabEvent>& events) {
    site_.oracle.Told(events, site_.now);
  };
}

void WorldMember::FillBay() {
  rig_pool_ = std::make_unique<RigPool>();
  std::vector<RigPool::Found> far;
  for (WorldRig& rig : site_.rigs) {
    rig.description.bench = &AnyBench();
    if (rig.elastic && rig.member == id_) {
      const auto accepted = [this](const RigId& id, std::uint64_t epoch) {
        site_.oracle.Accepted(id, epoch, site_.sender);
      };
      rig_pool_->Add(rig.description, "bench", [about = rig.description, accepted] {
        return std::make_shared<RehearsedRig>(about, std::make_shared<RigBody>(about.id, accepted));
      });
    } else if (rig.member == id_) {
      rig_pool_->AddResident(std::make_shared<RehearsedRig>(rig.description, rig.body), "bench");
    } else if (rig.member.empty()) {
      const Way way = [this, body = rig.body]() -> std::optional<WorldTime> {
        if (!body->answers() || site_.random.Chance(site_.calm ? 0.0 : 0.2)) return std::nullopt;
        return site_.now + site_.random.Between(milliseconds(0), milliseconds(500));
      };
      const auto held =
          std::make_shared<RehearsedRig>(rig.description, rig.body, rig.line, site_.sender, way);
      RigPool::Found found;
      found.status.description = rig.description;
      found.status.profile = "bench";
      found.status.remote.emplace();
      found.status.remote->state = hardware::RigState::kIdle;
      found.make = [held] { return held; };
      far.push_back(std::move(found));
    }
  }
  if (far.empty()) return;
  rig_pool_->SetFinder([far] {
    std::vector<RigPool::Found> all = far;
    for (RigPool::Found& each : all) {
      each.status.state = each.make()->state();
      const bool silent = each.status.state == hardware::RigState::kOffline;
      each.status.remote->state = each.status.state;
      each.status.remote->link = silent ? hardware::LinkState::kLost : hardware::LinkState::kBack;
    }
    return all;
  });
}

WorldRig& WorldMember::RigOf(const RigId& id) {
  return *std::find_if(site_.rigs.begin(), site_.rigs.end(), [&](const WorldRig& rig) {
    return rig.description.id == id;
  });
}

bool WorldMember::Start() {
  FillBay();
  LabServiceOptions options;
  options.member = id_;
  options.alone = !site_.shared;
  options.own_thread = false;
  if (site_.clock_checked) options.clock_error_max = seconds(1);
  try {
    auto opened = LabService::Open(
        std::make_unique<FaultyStore>(open_(), faults_), clock_, *this, std::move(options));
    if (opened.ok()) service_ = std::move(opened).value();
  } catch (const Crash&) {
  }
  if (service_ == nullptr) {
    Die();
    return false;
  }
  roll_call_.emplace(*service_, clock_, [](std::string_view) {});
  access_ = std::make_unique<RigAccess>(*service_, *rig_pool_, clock_, [](std::string_view) {});
  heard_ = true;
  Show();
  return true;
}

/// What it held at far rigs plays on until their watchdogs end it.
void WorldMember::Die() {
  access_.reset();
  if (alive()) {
    // Nobody starts a server again on a machine whose clock is an hour off.
    clock_.Set(clock_.off() + (service_->Now() - clock_.Wall()));
  }
  for (const Run& run : runs_) site_.oracle.RunCut(run.hold.lease().session);
  roll_call_.reset();
  checks_.clear();
  asked_checks_ = {};
  runs_.clear();
  late_.clear();
  old_checks_.clear();
  service_.reset();
  rig_pool_.reset();
  faults_.next = NextWrite::kStored;
  frozen_until_ = {};
}

void WorldMember::Guarded(const std::function<void()>& call) {
  const std::int64_t before = faults_.stored;
  heard_ = false;
  try {
    call();
  } catch (const Crash&) {
    ++site_.report.crashes;
    site_.oracle.Trouble(site_.now + std::chrono::minutes(1));
    return Die();
  }
  heard_ = faults_.stored != before;
  if (heard_) Show();
}

void WorldMember::Show() {
  const auto state = service_->state();
  const std::string broken = FindBrokenInvariant(*state);
  if (!broken.empty()) site_.oracle.Broken("invariant", broken);
  site_.oracle.Shown(Published(*state), {site_.now, service_->Now(), id_});
}

void WorldMember::Turn() {
  if (!awake()) {
    was_frozen_ = true;
    return;
  }
  if (std::exchange(was_frozen_, false)) {
    // What has come in the meantime is done before the service has its turn.
    AcquireLate();
    for (int i = 0; i < 3 && alive(); ++i) CommandRun();
    if (!alive()) return;
  }
  Guarded([this] { (void)service_->TickNow(); });
  if (alive()) Guarded([this] { roll_call_->Take(rig_pool_->List()); });
  if (alive()) GoOnWithChecks();
  if (alive()) AcquireLate();
  if (alive()) GoOnWithRuns();
  if (alive() && site_.random.Chance(0.2)) CommandRun();
}

/// RigUpkeep::CheckLoop without its threads.
void WorldMember::GoOnWithChecks() {
  while (!asked_checks_.empty()) checks_.push_back({asked_checks_.Begin(), site_.now});
  for (auto check = checks_.begin(); check != checks_.end();) {
    const bool over = GoOnWith(*check);
    if (!alive()) return;
    check = over ? checks_.erase(check) : std::next(check);
  }
}

/// @returns whether its verdict was told
bool WorldMember::GoOnWith(Check& check) {
  const RigId& rig = check.lease.rig;
  if (!check.done) {
    site_.sender = {UserId{}, id_, site_.now, site_.oracle.answers()};
    const bool waits = OlderRunOn(rig, check.lease.epoch);
    if (waits && site_.now - check.asked < kRigPatience) return false;
    auto hold = rig_pool_->Acquire(check.lease, milliseconds(0));
    check.done = site_.now;
    if (!hold.ok()) {
      check.verdict = NotBegun(hold.error());
    } else {
      check.hold = std::move(hold.value());
      site_.oracle.CheckBegan(rig, check.lease.epoch, site_.now);
      const core::Status taken = check.hold.rig().Arm({}, check.hold.epoch());
      const bool slow = !site_.calm && site_.random.Chance(0.1);
      const WorldTime length = site_.random.Between(seconds(5), seconds(slow ? 40 : 18));
      if (taken.ok()) {
        *check.done += length;
      } else {
        check.verdict = VerdictOf(taken.error());
      }
    }
  }
  if (site_.now < *check.done && !check.hold.revoked()) return false;
  if (!check.verdict) EndCheck(check);
  check.hold.Release();
  if (!check.verdict) return true;
  bool again = false;
  Guarded([&] {
    again = TellVerdict(*service_, check.lease, *check.verdict, [](std::string_view) {});
  });
  if (alive() && !again) asked_checks_.End(check.lease);
  return !again;
}

void WorldMember::EndCheck(Check& check) {
  const RigId& rig = check.lease.rig;
  const std::uint64_t epoch = check.lease.epoch;
  if (check.hold.revoked()) {
    check.verdict = RigVerdict{.text = "a newer lease exists"};
    return;
  }
  if (!site_.calm && site_.random.Chance(0.02)) {  // its thread hangs: no result
    return site_.oracle.RigTrouble(RigOf(rig).description.rig_class, site_.now);
  }
  const bool passes = site_.calm || site_.random.Chance(0.97);
  if (!passes) ++site_.report.quarantines;
  site_.oracle.CheckEnded(rig, epoch, passes, site_.now);
  old_checks_.emplace_back(rig, epoch);
  if (old_checks_.size() > kOldChecksKept) old_checks_.erase(old_checks_.begin());
  check.verdict = RigVerdict{.passed = passes, .text = "rehearsal"};
}

void WorldMember::RepeatOldCheck() {
  if (old_checks_.empty()) return;
  const auto count = static_cast<std::int64_t>(old_checks_.size());
  const auto [rig, epoch] = old_checks_[static_cast<std::size_t>(site_.random.Below(count))];
  const auto state = service_->state();
  const auto known = state->rigs.find(rig);
  const bool newest = known != state->rigs.end() && known->second.epoch == epoch &&
                      known->second.status == RigStatus::kCleaning;
  if (newest) return;
  const auto done = Do([&, rig = rig, epoch = epoch](Scheduler& lab, WallTime now) {
    return lab.CleaningDone(rig, epoch, true, "once more", now);
  });
  if (done && done->ok()) {
    site_.oracle.Broken("check between users", "the result of an old check counts on " + rig);
  }
}

bool WorldMember::OlderRunOn(const RigId& rig, std::uint64_t epoch) const {
  const auto older = [&](const RigHandle& hold) {
    return hold.lease().rig == rig && hold.lease().epoch < epoch;
  };
  return std::any_of(runs_.begin(), runs_.end(), [&](const Run& r) { return older(r.hold); }) ||
         std::any_of(checks_.begin(), checks_.end(), [&](const Check& c) {
           return c.done.has_value() && older(c.hold);
         });
}

void WorldMember::BeginRun(UserId user, const Session* session, Milliseconds length) {
  if (session != nullptr && OlderRunOn(session->rig, session->epoch)) return;
  if (session != nullptr && session->user == user && site_.random.Chance(0.2)) {
    // A busy machine: the lease is known, and the rig is asked for later.
    late_.push_back({LeaseOf(*session), user, site_.now + site_.random.Exponential(seconds(3))});
    return;
  }
  const RigId rig = session == nullptr ? "" : session->rig;
  const StartedBy by = session != nullptr && session->kind == TicketKind::kJob ? StartedBy::kJob
                                                                               : StartedBy::kPerson;
  std::optional<core::Result<RigHandle>> hold;
  const auto before = service_->state();
  Guarded([&] { hold = access_->Hold(PrincipalOf(user), by, rig, AnyBench(), length); });
  if (!alive() || !hold) return;
  const bool simulators_full =
      rig.empty() && !hold->ok() && hold->error().code == core::ErrorCode::kBusy && heard_;
  if (simulators_full) {
    const auto after = service_->state();
    std::ptrdiff_t free = 0;
    for (const auto& [id, each] : before->rigs) {
      const bool promised = std::min(BusyFrom(*before, id), BusyFrom(*after, id)) <
                            service_->Now() + 2 * length + minutes(11);
      const bool ready = each.elastic && each.server == id_ && each.status == RigStatus::kReady &&
                         after->rigs.at(id) == each;
      if (ready && !promised) ++free;
    }
    // Who is second in line leaves the one that is free to the first.
    const auto& said = hold->error().parameters;
    const auto place = std::ranges::find(said, "place", &core::ErrorParameter::name);
    if (free >= (place == said.end() ? 1 : std::stol(place->value))) {
      site_.oracle.Broken("simulators are elastic", "no practice though one is free");
    }
  }
  Hold(std::move(*hold), user, length);
}

void WorldMember::Hold(core::Result<RigHandle> hold, UserId user, Milliseconds length) {
  if (!hold.ok()) return;
  site_.sender = {user, id_, site_.now, site_.oracle.answers()};
  Run run{std::move(hold.value()), user, site_.now + length};
  const hardware::Epoch epoch = run.hold.epoch();
  const bool plays =
      service_->InForce() && run.hold.rig().Arm({}, epoch).ok() && run.hold.rig().Start(epoch).ok();
  if (!plays) return Guarded([&] { run.hold.Release(); });
  site_.oracle.RunBegan(run.hold.lease().session);
  runs_.push_back(std::move(run));
  Guarded([this] { (void)service_->TickNow(); });
}

void WorldMember::AcquireLate() {
  for (const Late& late : std::exchange(late_, {})) {
    if (site_.now < late.at || OlderRunOn(late.lease.rig, late.lease.epoch)) {
      late_.push_back(late);
      continue;
    }
    Hold(rig_pool_->Acquire(late.lease, milliseconds(0)), late.user, seconds(30));
    if (!alive()) return;
  }
}

void WorldMember::GoOnWithRuns() {
  for (auto entry = runs_.begin(); entry != runs_.end();) {
    Run& run = *entry;
    if (run.hold.revoked() && !run.let_go) {
      run.let_go = site_.now + site_.random.Between(milliseconds(0), seconds(2));
    }
    const bool over = run.let_go ? site_.now >= *run.let_go : site_.now >= run.until;
    if (!over) {
      ++entry;
      continue;
    }
    const SessionId session = run.hold.lease().session;
    Guarded([&] { run.hold.Release(); });
    site_.oracle.RunEnded(session, site_.now);
    if (!alive()) return;
    entry = runs_.erase(entry);
  }
}

/// The page's question whether this user may command comes before; a command on its way may be
/// older.
void WorldMember::CommandRun() {
  if (runs_.empty()) return;
  auto run = runs_.begin();
  std::advance(run, site_.random.Below(static_cast<std::int64_t>(runs_.size())));
  const Lease& lease = run->hold.lease();
  const auto state = service_->state();
  const auto rig = state->rigs.find(lease.rig);
  const bool stale = rig != state->rigs.end() && lease.epoch < rig->second.epoch;
  if (stale) ++site_.report.stale_commands_tried;
  if (!service_->InForce()) return;
  site_.sender = {run->user, id_, site_.now, site_.oracle.answers()};
  const core::Status sent = run->hold.rig().Command(run->hold.epoch(), {});
  if (sent.ok() && !stale) ++site_.report.commands_accepted;
}

void WorldMember::TryToCommand(UserId user, const RigId& rig) {
  if (!access_->MayCommand(PrincipalOf(user), rig)) return;
  const auto found = rig_pool_->Find(rig);
  if (!found.ok() || !NeedsSession(found.value())) return;
  const auto state = service_->state();
  for (const auto& [id, session] : state->sessions) {
    const bool own = session.user == user && session.rig == rig;
    if (own && session.state == SessionState::kActive) return;
  }
  site_.oracle.Broken("spectators", "somebody without a session may command " + rig);
}

}  // namespace faultlab::server::lab::rehearsal
