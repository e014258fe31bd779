#include "server/lab/rehearsal/lab_world.h"

#include <soci/soci.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "core/types/check.h"
#include "server/lab/rehearsal/published_rules.h"
#include "server/lab/timeline.h"

namespace faultlab::server::lab::rehearsal {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

constexpr WorldTime kChunk = seconds(4);
/// A server takes a step of its clock for right after 5 minutes.
constexpr WorldTime kClockDoubted = minutes(6);
constexpr std::size_t kCredentialsKept = 64;

/// Empties the lab of a database that belongs to the rehearsal.
void Empty(Database& database) {
  const core::Status done =
      database.Write(Durability::kPromise, [](Transaction& tx) -> core::Status {
        for (const char* table : {"lab_session",
                                  "lab_ticket",
                                  "lab_booking",
                                  "lab_outage",
                                  "lab_usage",
                                  "lab_event",
                                  "lab_member",
                                  "lab_policy",
                                  "lab_rig"}) {
          tx.sql() << std::string("DELETE FROM ") + table;
        }
        tx.sql() << "UPDATE lab_meta SET version = 0, next_id = 1 WHERE id = 1";
        return core::Done{};
      });
  if (!done.ok()) LAB_CHECK(false, done.error().message);
}

/// The next of the times at which people book.
WallTime OnGrid(WallTime time) {
  const Milliseconds beyond = time.time_since_epoch() % Milliseconds(minutes(5));
  return time + (Milliseconds(minutes(5)) - beyond);
}

template <typename Map>
typename Map::key_type AnyKey(Random& random, const Map& map) {
  if (map.empty()) return {};
  auto entry = map.begin();
  std::advance(entry, random.Below(static_cast<std::int64_t>(map.size())));
  return entry->first;
}

}  // namespace

LabWorld::LabWorld(std::uint64_t seed,
                   std::uint64_t kind,
                   const WorldStore& store,
                   RehearsalReport& report)
    : site_(seed,
            report,
            store.databases.empty() ? kind % 2 == 0 : store.databases.size() > 1,
            kind % 3 == 0) {
  site_.clock_checked = site_.shared && store.databases.empty();
  MakeRigs();
  MakeMembers(store);
  for (auto& member : members_) LAB_CHECK(member->Start(), member->id());
  const auto changed =
      members_.front()->Do([](Scheduler& lab, WallTime now) -> core::Result<PolicySettings> {
        PolicySettings settings = static_cast<const PolicySettings&>(lab.policy());
        settings.extended_max = kExtended;
        return lab.ChangePolicy(settings, now);
      });
  LAB_CHECK(changed && changed->ok(), members_.front()->id());
}

std::string LabWorld::About() const {
  return std::string(site_.shared ? "two members" : "one member") +
         (site_.calm ? ", calm" : ", storm");
}

void LabWorld::MakeRigs() {
  const auto add = [&](const std::string& id,
                       const std::string& rig_class,
                       const std::string& member,
                       hardware::RigKind kind) {
    WorldRig rig;
    rig.description.id = id;
    rig.description.rig_class = rig_class;
    rig.description.kind = kind;
    rig.elastic = kind == hardware::RigKind::kSimulated;
    rig.member = member;
    if (!rig.elastic) {
      rig.body = std::make_shared<RigBody>(id, [this](const RigId& name, std::uint64_t epoch) {
        // A check has no user; the oracle hears of it from the member.
        if (site_.sender.user == UserId{}) return;
        site_.oracle.Accepted(name, epoch, site_.sender);
      });
      rig.line = std::make_shared<std::deque<InFlight>>();
    }
    site_.rigs.push_back(std::move(rig));
  };
  const int servers = site_.shared ? 2 : 1;
  for (int server = 0; server < servers; ++server) {
    const std::string member(1, static_cast<char>('a' + server));
    const auto benches = 1 + site_.random.Below(site_.shared ? 2 : 4);
    for (std::int64_t i = 0; i < benches; ++i) {
      const bool second_class = i > 0 && site_.random.Chance(0.3);
      add(member + "-bench-" + std::to_string(i),
          second_class ? "b" : "a",
          member,
          hardware::RigKind::kBench);
    }
    const auto simulators = site_.random.Below(3);
    for (std::int64_t i = 0; i < simulators; ++i) {
      add(member + "-sim-" + std::to_string(i), "sim", member, hardware::RigKind::kSimulated);
    }
  }
  const auto far = site_.random.Below(3);
  for (std::int64_t i = 0; i < far; ++i) {
    add("far-" + std::to_string(i), "a", "", hardware::RigKind::kRemote);
  }
}

void LabWorld::MakeMembers(const WorldStore& store) {
  const std::size_t servers = site_.shared ? 2 : 1;
  memory_->keep_events = false;
  if (!store.databases.empty()) Empty(*store.databases.front());
  for (std::size_t i = 0; i < servers; ++i) {
    WorldMember::OpenStore open = [this]() -> std::unique_ptr<LabStore> {
      return std::make_unique<MemoryStore>(
          memory_, site_.shared, [this] { return kWorldStart + site_.now; });
    };
    if (!store.databases.empty()) {
      open = [database = store.databases.at(i)]() -> std::unique_ptr<LabStore> {
        return std::make_unique<DatabaseLabStore>(*database);
      };
    }
    members_.push_back(std::make_unique<WorldMember>(
        site_, std::string(1, static_cast<char>('a' + i)), std::move(open)));
  }
  restart_at_.resize(servers);
  cut_until_.resize(servers);
  clock_back_.resize(servers);
}

void LabWorld::Step() {
  ++site_.report.steps;
  if (!site_.calm && site_.random.Chance(0.006)) return Misfortune();
  const double dice = site_.random.Uniform();
  WorldMember* member = AnyAwake();
  if (dice < 0.30 || member == nullptr) {
    const bool long_one = site_.random.Chance(0.02);
    return Pass(site_.random.Exponential(long_one ? seconds(90) : seconds(5)));
  }
  Person(*member, (dice - 0.30) / 0.70);
}

void LabWorld::Pass(WorldTime time) {
  const WorldTime end = site_.now + time;
  while (site_.now < end) {
    site_.now = std::min(end, site_.now + kChunk);
    Deliver();
    Restart();
    const bool first_goes_first = site_.random.Chance(0.5);
    for (std::size_t i = 0; i < members_.size(); ++i) {
      WorldMember& member = *members_[first_goes_first ? i : members_.size() - 1 - i];
      if (member.alive()) member.Turn();
    }
  }
}

/// What was on its way to a far rig arrives.
void LabWorld::Deliver() {
  for (WorldRig& rig : site_.rigs) {
    if (rig.line == nullptr) continue;
    while (!rig.line->empty() && rig.line->front().arrives <= site_.now) {
      const InFlight message = rig.line->front();
      rig.line->pop_front();
      if (message.fence) {
        rig.body->Fence(message.epoch);
      } else {
        site_.sender = message.sender;
        (void)rig.body->Accept(message.epoch);
      }
    }
  }
}

void LabWorld::Restart() {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    WorldMember& member = *members_[i];
    member.faults().away = site_.now < cut_until_[i];
    if (clock_back_[i] > WorldTime{} && site_.now >= clock_back_[i]) {
      clock_back_[i] = {};
      member.clock().Set({});
      if (!site_.shared) site_.oracle.ClockWasSet(site_.now);
    }
    if (member.alive()) {
      // The turn that follows a step of the clock is a moment that chance would seldom hit.
      const bool follows = member.service().Now() != member.clock().Wall() &&
                           site_.now - clock_set_ >= kClockDoubted - minutes(1);
      if (!site_.shared && follows && answer_lost_after_step_) {
        member.faults().next = NextWrite::kAnswerLost;
        site_.oracle.Trouble(site_.now + minutes(1));
      }
      continue;
    }
    clock_back_[i] = {};
    site_.oracle.Trouble(site_.now + minutes(1));
    if (restart_at_[i] == WorldTime{}) {
      restart_at_[i] = site_.now + site_.random.Exponential(seconds(12));
    } else if (site_.now >= restart_at_[i] && member.Start()) {
      restart_at_[i] = {};
    }
  }
}

/// A fault of a server, the store, the network, a clock or a rig.
void LabWorld::Misfortune() {
  Random& random = site_.random;
  const auto index =
      static_cast<std::size_t>(random.Below(static_cast<std::int64_t>(members_.size())));
  WorldMember& member = *members_[index];
  const double dice = random.Uniform();
  // A server that dies before it follows a step of its clock does not know of the step.
  if (dice < 0.28 && !site_.shared && site_.now - clock_set_ < 2 * kClockDoubted) return;
  if (dice < 0.12) {
    member.faults().next = NextWrite::kCrashBefore;
  } else if (dice < 0.24) {
    member.faults().next = NextWrite::kCrashAfter;
  } else if (dice < 0.28) {
    if (member.alive()) ++site_.report.crashes;
    member.Die();
    restart_at_[index] = site_.now + random.Exponential(seconds(30));
  } else if (dice < 0.36) {
    member.faults().next = NextWrite::kAnswerLost;
    site_.oracle.Trouble(site_.now + minutes(1));
  } else if (dice < 0.42) {
    member.faults().next = NextWrite::kRefused;
    site_.oracle.Trouble(site_.now + minutes(1));
  } else if (dice < 0.52) {
    const WorldTime until = site_.now + random.Exponential(seconds(20));
    const bool all = random.Chance(0.5);
    for (std::size_t i = 0; i < members_.size(); ++i) {
      if (all || i == index) cut_until_[i] = until;
    }
    site_.oracle.Trouble(until + minutes(2));
  } else if (dice < 0.64 && site_.shared) {
    const WorldTime until = site_.now + random.Exponential(seconds(12));
    member.Freeze(until);
    site_.oracle.Trouble(until + minutes(1));
  } else if (dice < 0.70) {
    if (!member.alive()) return;
    ++site_.report.clock_jumps;
    const bool back = site_.shared || random.Chance(0.4);
    if (site_.shared && !site_.clock_checked) return;  // there NTP keeps the clocks
    if (!site_.shared && site_.now - clock_set_ < 2 * kClockDoubted) return;
    clock_set_ = site_.now;
    answer_lost_after_step_ = random.Chance(0.4);
    const Milliseconds jump = random.Chance(0.5) ? hours(1) : -hours(1);
    member.clock().Set(member.clock().off() + jump);
    clock_back_[index] = back ? site_.now + random.Exponential(seconds(60)) : WorldTime{};
    if (site_.shared) {
      site_.oracle.Trouble(clock_back_[index] + minutes(1));
    } else {
      site_.oracle.ClockWasSet(site_.now);
    }
  } else if (dice < 0.85) {
    WorldRig& rig = site_.rigs[static_cast<std::size_t>(
        random.Below(static_cast<std::int64_t>(site_.rigs.size())))];
    rig.cut_until = site_.now + random.Exponential(minutes(random.Chance(0.3) ? 20 : 2));
  } else if (member.awake()) {
    Operate(member);
  }
}

void LabWorld::Operate(WorldMember& member) {
  Random& random = site_.random;
  const RigId rig = AnyRig();
  const auto state = member.state();
  const auto known = state->rigs.find(rig);
  if (known == state->rigs.end()) return;
  site_.oracle.RigTrouble(known->second.rig_class, site_.now);
  const double dice = random.Uniform();
  if (dice < 0.2) {
    ++site_.report.quarantines;
    site_.oracle.AskedToQuarantine(rig);
    (void)member.Do(
        [&](Scheduler& lab, WallTime now) { return lab.Quarantine(rig, "operator", now); });
  } else if (dice < 0.3) {
    (void)member.Do([&](Scheduler& lab, WallTime now) { return lab.Recheck(rig, now); });
  } else if (dice < 0.4) {
    const std::uint64_t seen = known->second.epoch + static_cast<std::uint64_t>(random.Below(3));
    (void)member.Do([&](Scheduler& lab, WallTime now) { return lab.Adopt(rig, seen, now); });
  } else if (dice < 0.7) {
    const WallTime start = member.service().Now() + random.Between(Milliseconds{0}, hours(2));
    const Interval during{start, start + random.Between(minutes(1), minutes(40))};
    (void)member.Do([&](Scheduler& lab, WallTime now) -> core::Status {
      const auto outage = lab.AddOutage(rig, during, "works", now);
      return outage.ok() ? core::Status(core::Done{}) : core::Status(outage.error());
    });
  } else {
    const OutageId outage = AnyKey(random, state->outages);
    (void)member.Do([&](Scheduler& lab, WallTime now) { return lab.RemoveOutage(outage, now); });
  }
}

void LabWorld::Person(WorldMember& member, double dice) {
  if (dice < 0.16) return AskForRig(member);
  if (dice < 0.32) return Accept(member);
  if (dice < 0.42) return Book(member);
  if (dice < 0.435) return BookWhatIsFree(member);
  if (dice < 0.53) return Claim(member);
  if (dice < 0.55) return Cancel(member);
  if (dice < 0.58) return End(member);
  if (dice < 0.62) return PassOn(member);
  if (dice < 0.65) return Extend(member);
  if (dice < 0.73) return Act(member);
  if (dice < 0.83) return Run(member);
  if (dice < 0.97) return member.CommandRun();
  if (dice < 0.98) return member.TryToCommand(AnyUser(), AnyRig());
  if (dice < 0.985) return member.RepeatOldCheck();
  // An operator puts right what stands in quarantine.
  const auto state = member.state();
  for (const auto& [id, rig] : state->rigs) {
    if (rig.status != RigStatus::kQuarantined) continue;
    (void)member.Do([&, &id = id](Scheduler& lab, WallTime now) { return lab.Release(id, now); });
    return;
  }
}

void LabWorld::AskForRig(WorldMember& member) {
  Random& random = site_.random;
  TicketRequest request;
  request.user = AnyUser();
  request.rig_class = AnyClass();
  request.kind = random.Chance(0.2) ? TicketKind::kJob : TicketKind::kPerson;
  const bool person = request.kind == TicketKind::kPerson;
  request.min =
      person ? random.Between(minutes(5), minutes(15)) : random.Between(minutes(1), minutes(5));
  request.want = request.min;
  if (person) {
    request.want += random.Between(Milliseconds{0}, minutes(30));
  } else {
    request.job = std::to_string(random.Below(100));
    request.weight = member.service().policy().job_weight_s;
  }
  const auto answer =
      member.Do([&](Scheduler& lab, WallTime now) { return lab.RequestTicket(request, now); });
  if (!answer || !answer->ok()) return;
  const auto state = member.state();
  if (person) {
    site_.oracle.Answered(request.user, request.rig_class, answer->value(), Published(*state));
  }
  const auto* ticket = std::get_if<Ticket>(&answer->value());
  for (const auto& [id, other] : state->tickets) {
    const bool same = !person && other.kind == TicketKind::kJob && other.user == request.user &&
                      other.job == request.job && ticket != nullptr && id != ticket->id &&
                      other.rig_class == request.rig_class;
    if (same) site_.oracle.Broken("one ticket", "a job waits twice");
  }
  if (const auto* session = std::get_if<Session>(&answer->value())) Remember(*session);
}

void LabWorld::Accept(WorldMember& member) {
  const auto state = member.state();
  TicketId id = AnyKey(site_.random, state->tickets);
  for (const auto& [ticket_id, ticket] : state->tickets) {
    const bool offered = ticket.state == TicketState::kOffered;
    if (offered && site_.random.Chance(0.4)) id = ticket_id;
  }
  const auto found = state->tickets.find(id);
  if (found == state->tickets.end()) return;
  if (site_.random.Chance(0.06)) {
    site_.oracle.AskedToLeave(id);
    (void)member.Do([&](Scheduler& lab, WallTime now) { return lab.LeaveTicket(id, now); });
    return;
  }
  const UserId user = site_.random.Chance(0.95) ? found->second.user : AnyUser();
  const auto session =
      member.Do([&](Scheduler& lab, WallTime now) { return lab.AcceptTicket(id, user, now); });
  if (!session || !session->ok()) return;
  Remember(session->value());
  if (user != found->second.user) {
    site_.oracle.Broken("hand-over", "a ticket was accepted by somebody else");
  }
}

void LabWorld::Book(WorldMember& member) {
  Random& random = site_.random;
  const Milliseconds ahead = random.Chance(0.5) ? Milliseconds(minutes(40)) : hours(4);
  const WallTime now = member.service().Now();
  const WallTime start = now + random.Between(-minutes(1), ahead);
  Interval during{start, start + random.Between(minutes(4), minutes(50))};
  if (random.Chance(0.6)) {  // as in the week grid of the page
    during.start = OnGrid(start);
    during.end = during.start + minutes(5) * (1 + random.Below(10));
  }
  (void)member.Do([&, user = AnyUser(), rig_class = AnyClass()](Scheduler& lab, WallTime at) {
    return lab.Book(user, rig_class, during, at);
  });
}

/// What the calendar shows as free can be booked.
void LabWorld::BookWhatIsFree(WorldMember& member) {
  Random& random = site_.random;
  member.Turn();
  if (!member.awake()) return;
  const auto state = member.state();
  const WallTime now = member.service().Now();
  const std::string rig_class = AnyClass();
  const WallTime from = OnGrid(now + minutes(random.Below(120)));
  const Policy& policy = member.service().policy();
  std::optional<Interval> free;
  if (random.Chance(0.5)) {
    const Milliseconds step = minutes(random.Chance(0.5) ? 30 : 15);
    const auto slots =
        Availability(*state, rig_class, {from, from + hours(1)}, step, step, now, policy);
    for (const Slot& slot : slots) {
      if (slot.free > 0) free = slot.during;
    }
  } else {
    const Milliseconds length = minutes(5 + random.Below(40));
    const auto starts =
        NextFree(*state, rig_class, {from, from + hours(4)}, length, 3, now, policy);
    if (!starts.empty()) free = Interval{starts.back(), starts.back() + length};
  }
  if (!free) return;
  const UserId guest{1000};  // without any other booking
  const auto booked =
      member.Do([&](Scheduler& lab, WallTime at) { return lab.Book(guest, rig_class, *free, at); });
  if (!booked) return;
  if (!booked->ok()) {
    if (booked->error().code != core::ErrorCode::kConflict || booked->error().field != "start") {
      return;
    }
    site_.oracle.Broken("free is bookable",
                        "shown as free, and refused: " + booked->error().message);
    return;
  }
  const Booking& booking = booked->value();
  site_.oracle.AskedToCancel(booking.id);
  (void)member.Do([&](Scheduler& lab, WallTime at) {
    return lab.CancelBooking(booking.id, booking.version, at);
  });
}

void LabWorld::Claim(WorldMember& member) {
  const auto state = member.state();
  BookingId id = AnyKey(site_.random, state->bookings);
  for (const auto& [booking_id, booking] : state->bookings) {
    const bool held = booking.state == BookingState::kHeld;
    if (held && site_.random.Chance(0.5)) id = booking_id;
  }
  const auto found = state->bookings.find(id);
  if (found == state->bookings.end()) return;
  const Booking& booking = found->second;
  const UserId user = site_.random.Chance(0.95) ? booking.user : AnyUser();
  const auto session =
      member.Do([&](Scheduler& lab, WallTime now) { return lab.ClaimBooking(id, user, now); });
  if (!session) return;
  if (session->ok()) {
    Remember(session->value());
    if (user == booking.user) return;
    return site_.oracle.Broken("hand-over", "a booking was claimed by somebody else");
  }
  const bool early = user == booking.user && booking.state == BookingState::kBooked &&
                     booking.during.start > member.service().Now();
  const core::Error& error = session->error();
  const bool named = error.code == core::ErrorCode::kConflict && !error.parameters.empty();
  const bool known = error.code == core::ErrorCode::kNotFound;  // it fell meanwhile
  if (early && !named && !known) {
    site_.oracle.Broken("claimed early", "the refusal does not tell when: " + error.message);
  }
}

void LabWorld::Cancel(WorldMember& member) {
  const auto state = member.state();
  const BookingId id = AnyKey(site_.random, state->bookings);
  const auto found = state->bookings.find(id);
  if (found == state->bookings.end()) return;
  const std::int64_t read = found->second.version + site_.random.Below(2) - 1;
  site_.oracle.AskedToCancel(id);
  const auto done =
      member.Do([&](Scheduler& lab, WallTime now) { return lab.CancelBooking(id, read, now); });
  if (done && done->ok() && read < found->second.version) {
    site_.oracle.Broken("bookings kept", "cancelled by somebody who had read an old version");
  }
}

void LabWorld::End(WorldMember& member) {
  const auto state = member.state();
  const Session* session = AnySession(*state);
  if (session == nullptr) return;
  site_.oracle.AskedToEnd(session->id);
  const auto reason = site_.random.Chance(0.7) ? EndReason::kEnded : EndReason::kOperator;
  (void)member.Do([&](Scheduler& lab, WallTime now) {
    return lab.EndSession(session->id, reason, "rehearsal", now);
  });
  // Somebody who does not know yet.
  if (member.alive()) member.CommandRun();
}

void LabWorld::PassOn(WorldMember& member) {
  const auto state = member.state();
  const Session* session = AnySession(*state);
  if (session == nullptr) return;
  const SessionId id = session->id;
  const UserId to = AnyUser();
  std::optional<core::Result<Session>> passed;
  if (site_.random.Chance(0.15)) {
    site_.oracle.TookOver(id, to);
    passed = member.Do(
        [&](Scheduler& lab, WallTime now) { return lab.TakeOver(id, to, "rehearsal", now); });
  } else {
    if (site_.random.Chance(0.7)) {
      const auto offered =
          member.Do([&](Scheduler& lab, WallTime now) { return lab.OfferControl(id, to, now); });
      if (!offered || offered->ok()) site_.oracle.OfferedControl(id, to);
    }
    if (!member.alive() || site_.random.Chance(0.3)) return;
    passed =
        member.Do([&](Scheduler& lab, WallTime now) { return lab.AcceptControl(id, to, now); });
  }
  if (!passed || !passed->ok()) return;
  Remember(passed->value());
  member.CommandRun();
}

void LabWorld::Extend(WorldMember& member) {
  const auto state = member.state();
  const Session* session = AnySession(*state);
  if (session == nullptr) return;
  site_.oracle.AskedToExtend(session->id);
  (void)member.Do([&](Scheduler& lab, WallTime now) { return lab.Extend(session->id, now); });
}

/// Signs of life, with epochs of any age.
void LabWorld::Act(WorldMember& member) {
  if (credentials_.empty()) return;
  const auto count = static_cast<std::int64_t>(credentials_.size());
  const Credential c = site_.random.Chance(0.4)
                           ? credentials_.back()
                           : credentials_[static_cast<std::size_t>(site_.random.Below(count))];
  if (site_.random.Chance(0.1)) {
    const auto there =
        member.Do([&](Scheduler& lab, WallTime now) { return lab.StillThere(c.session, now); });
    if (there && there->ok()) site_.oracle.Active(c.session, site_.now);
    return;
  }
  const auto done = member.Do(
      [&](Scheduler& lab, WallTime now) { return lab.ControlActivity(c.session, c.epoch, now); });
  const bool accepted = done && done->ok();
  if (!done || !member.alive()) return;
  const auto state = member.state();
  const auto session = state->sessions.find(c.session);
  const bool current = session != state->sessions.end() && session->second.epoch == c.epoch;
  if (!current) ++site_.report.stale_commands_tried;
  if (!accepted) return;
  if (!current) site_.oracle.Broken("stale command", "a sign of life with an old epoch counts");
  site_.oracle.Active(c.session, site_.now);
}

void LabWorld::Run(WorldMember& member) {
  const Milliseconds length =
      site_.random.Between(seconds(5), seconds(site_.random.Chance(0.15) ? 900 : 90));
  if (site_.random.Chance(0.2)) return member.BeginRun(AnyUser(), nullptr, length);
  const auto state = member.state();
  const Session* session = AnySession(*state);
  if (session == nullptr || session->state != SessionState::kActive) return;
  if (state->rigs.at(session->rig).server != member.id()) return;
  if (session->kind == TicketKind::kPractice) return;
  const bool spectator = site_.random.Chance(0.05);
  member.BeginRun(spectator ? AnyUser() : session->user, session, length);
}

void LabWorld::Remember(const Session& session) {
  if (session.epoch == 0) return;
  credentials_.push_back({session.id, session.epoch});
  if (credentials_.size() > kCredentialsKept) credentials_.erase(credentials_.begin());
}

std::string LabWorld::AnyClass() {
  static constexpr std::array<const char*, 5> kClasses = {"a", "a", "a", "b", "sim"};
  return kClasses.at(static_cast<std::size_t>(site_.random.Below(5)));
}

RigId LabWorld::AnyRig() {
  const auto count = static_cast<std::int64_t>(site_.rigs.size());
  return site_.rigs[static_cast<std::size_t>(site_.random.Below(count))].description.id;
}

WorldMember* LabWorld::AnyAwake() {
  const auto count = static_cast<std::int64_t>(members_.size());
  WorldMember& any = *members_[static_cast<std::size_t>(site_.random.Below(count))];
  return any.awake() ? &any : nullptr;
}

const Session* LabWorld::AnySession(const LabState& state) {
  const auto found = state.sessions.find(AnyKey(site_.random, state.sessions));
  return found == state.sessions.end() ? nullptr : &found->second;
}

}  // namespace faultlab::server::lab::rehearsal
