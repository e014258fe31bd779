#include "tests/world/lab_world.h"

#include <soci/soci.h>

#include <algorithm>
#include <array>

#include "core/types/check.h"
#include "tests/world/published_rules.h"

namespace faultlab::server::lab::rehearsal {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

constexpr WorldTime kChunk = seconds(4);
/// A server takes a step of its clock for right after 5 minutes.
constexpr WorldTime kClockDoubted = minutes(6);

/// Empties the lab of a database that belongs to the rehearsal.
void Empty(Database& database) {
  const core::Status done =
      database.Write(Durability::kPromise, [](Transaction& tx) -> core::Status {
        for (const char* table : {"lab_session",
                                  "lab_ticket",
                                  "lab_booking",
                                  "lab_outage",
                                  "lab_window",
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

}  // namespace

LabWorld::LabWorld(std::uint64_t seed,
                   std::uint64_t kind,
                   const WorldStore& store,
                   RehearsalReport& report)
    : site_(seed,
            report,
            store.databases.empty() ? kind % 2 == 0 : store.databases.size() > 1,
            kind % 3 == 0,
            kExtendedInWorlds) {
  site_.clock_checked = site_.shared && store.databases.empty();
  MakeRigs();
  MakeMembers(store);
  for (auto& member : members_) LAB_CHECK(member->Start(), member->id());
  const auto changed =
      members_.front()->Do([](Scheduler& lab, WallTime now) -> core::Result<PolicySettings> {
        PolicySettings settings = static_cast<const PolicySettings&>(lab.policy());
        settings.extended_max = kExtendedInWorlds;
        return lab.ChangePolicy(settings, now);
      });
  LAB_CHECK(changed && changed->ok(), members_.front()->id());
  for (auto& member : members_) member->Turn();  // they bring their rigs
  if (site_.random.Chance(0.6)) SetHours();
}

/// Every three hours closed for a while, an hour of one course, and one of the other.
void LabWorld::SetHours() {
  const bool closes = site_.random.Chance(0.7);
  const auto add = [&](std::int64_t course, Milliseconds from, Milliseconds to) {
    Window window;
    window.rig_class = "a";
    window.course = course;
    window.title = "hours";
    for (int i = 0; i < 10; ++i) {
      const WallTime round = kWorldStart + i * hours(3);
      window.times.push_back({round + from, round + to});
    }
    const auto added = members_.front()->Do(
        [&](Scheduler& lab, WallTime now) { return lab.AddWindow(window, now); });
    LAB_CHECK(added, window.course);
    LAB_CHECK(added->ok(), added->error().message);
  };
  if (closes) add(0, minutes(10), minutes(170));
  add(1, minutes(60), minutes(60 + 5 * (3 + site_.random.Below(9))));
  if (site_.random.Chance(0.5)) add(2, minutes(150), minutes(180));
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
    if (rig.body == nullptr) continue;
    rig.body->Answer(site_.now >= rig.cut_until);
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
    if (rig.body == nullptr) return;  // a simulator has no cable
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
