#include "server/lab/rehearsal/simulated_weeks.h"

#include <algorithm>
#include <map>
#include <vector>

#include "core/types/check.h"
#include "server/lab/rehearsal/random.h"
#include "server/lab/scheduler.h"

namespace faultlab::server::lab {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

constexpr int kRigs = 4;
constexpr int kUsers = 18;
constexpr Milliseconds kStep{seconds(5)};
constexpr Milliseconds kSlot{minutes(30)};
constexpr double kBooksAhead = 0.25;  ///< share of requests that are bookings for a later hour
constexpr double kNoShow = 0.15;      ///< share of bookings whose user does not come
constexpr Milliseconds kOpens{hours(8)};
constexpr Milliseconds kCloses{hours(20)};
constexpr WallTime kMonday{Milliseconds{1'767'571'200'000}};  // 2026-01-05T00:00Z
constexpr const char* kClass = "bench";

bool Open(WallTime time) {
  const auto of_day = (time - kMonday) % hours(24);
  return of_day >= kOpens && of_day < kCloses;
}

/// The next request of a user: made at `at`, for `length` of useful work.
struct Wish {
  int user = 0;
  WallTime at{};
  Milliseconds length{};
  bool ahead = false;  ///< a booking that starts `lead` later
  Milliseconds lead{};
  bool no_show = false;
};

/// Users think, request the rig, use it, and think again. All users are equal, and there are more
/// than the rigs can serve.
class People {
 public:
  explicit People(std::uint64_t seed) : random_(seed) {}
  Wish Next(int user, WallTime after) {
    Wish wish;
    wish.user = user;
    wish.at = after + random_.Exponential(minutes(45));
    while (!Open(wish.at)) wish.at += random_.Exponential(hours(1));
    const Milliseconds worked = minutes(8) + random_.Exponential(minutes(16));
    wish.length = std::min<Milliseconds>(worked, minutes(60));
    wish.ahead = random_.Chance(kBooksAhead);
    wish.lead = random_.Between(hours(1), hours(6));
    wish.no_show = wish.ahead && random_.Chance(kNoShow);
    return wish;
  }
  Milliseconds Check() { return random_.Between(seconds(8), seconds(20)); }
  Milliseconds Reaction() { return random_.Between(seconds(2), seconds(25)); }

 private:
  Random random_;
};

struct Tally {
  std::vector<double> waits_min;
  std::map<int, double> got_s;
  double useful_open_s = 0.0;
  double lost_s = 0.0;
  int wishes = 0;
  int served = 0;

  WeekFigures Figures(int weeks) {
    const double capacity_s =
        kRigs * 7.0 * weeks * std::chrono::duration<double>(kCloses - kOpens).count();
    WeekFigures figures;
    figures.utilisation = useful_open_s / capacity_s;
    figures.no_show_loss = lost_s / capacity_s;
    figures.served = wishes == 0 ? 1.0 : static_cast<double>(served) / wishes;
    std::sort(waits_min.begin(), waits_min.end());
    if (!waits_min.empty()) {
      figures.median_wait_min = waits_min[waits_min.size() / 2];
      figures.p95_wait_min = waits_min[waits_min.size() * 95 / 100];
    }
    return figures;
  }
};

double Seconds(Milliseconds duration) {
  return std::chrono::duration<double>(duration).count();
}

/// Only time within opening hours counts; at night the rigs cost nothing.
double OpenSeconds(WallTime from, WallTime to) {
  double open_s = 0.0;
  for (WallTime t = from; t < to; t += kStep) {
    if (Open(t)) open_s += Seconds(std::min(kStep, to - t));
  }
  return open_s;
}

/// For calls that the scheduler has no reason to refuse in these weeks.
void Must(const core::Status& done) {
  if (!done.ok()) LAB_CHECK(false, done.error().message);
}

class OurWeek {
 public:
  OurWeek(int weeks, std::uint64_t seed) : weeks_(weeks), people_(seed) {
    for (int i = 0; i < kRigs; ++i) {
      const RigId id = "bench-" + std::to_string(i);
      Must(scheduler_.AddRig(id, kClass, false));
      Must(scheduler_.Claim(id, "server", now_));
    }
    for (int user = 0; user < kUsers; ++user) desks_.push_back({people_.Next(user, now_)});
  }

  void Run(RehearsalReport& report) {
    const WallTime end = kMonday + hours(24 * 7 * weeks_);
    for (; now_ < end; now_ += kStep) {
      Checks();
      scheduler_.Tick(now_);
      for (Desk& desk : desks_) Live(desk);
      Account();
    }
    report.ours = tally_.Figures(weeks_);
    double sum = 0.0;
    double squares = 0.0;
    for (int user = 0; user < kUsers; ++user) {
      sum += tally_.got_s[user];
      squares += tally_.got_s[user] * tally_.got_s[user];
    }
    report.jain = squares == 0.0 ? 1.0 : sum * sum / (kUsers * squares);
    int held = 0;
    for (const auto& [day, broken] : days_) held += broken ? 0 : 1;
    report.days_estimate_held = days_.empty() ? 1.0 : held / static_cast<double>(days_.size());
  }

 private:
  enum class Mood { kThinks, kQueues, kReacts, kWorks, kWaitsForBooking };
  struct Desk {
    Wish wish;
    Mood mood = Mood::kThinks;
    TicketId ticket{};
    BookingId booking{};
    SessionId session{};
    WallTime asked{};
    WallTime until{};
    WallTime began{};
    std::optional<WallTime> first_expected{};
  };

  void Live(Desk& desk) {
    const UserId user{desk.wish.user + 1};
    switch (desk.mood) {
      case Mood::kThinks:
        if (now_ >= desk.wish.at) Ask(desk, user);
        break;
      case Mood::kQueues: {
        const auto ticket = scheduler_.state().tickets.find(desk.ticket);
        if (ticket == scheduler_.state().tickets.end()) {
          Rethink(desk);
        } else {
          if (!desk.first_expected) desk.first_expected = ticket->second.first_expected;
          if (ticket->second.state == TicketState::kOffered) {
            desk.mood = Mood::kReacts;
            desk.until = now_ + people_.Reaction();
          }
        }
        break;
      }
      case Mood::kReacts:
        if (now_ < desk.until) break;
        if (const auto session = scheduler_.AcceptTicket(desk.ticket, user, now_); session.ok()) {
          Begin(desk, session.value());
        } else {
          desk.mood = Mood::kQueues;
        }
        break;
      case Mood::kWaitsForBooking:
        WaitForBooking(desk, user);
        break;
      case Mood::kWorks:
        Work(desk);
        break;
    }
  }

  void Ask(Desk& desk, UserId user) {
    ++tally_.wishes;
    desk.asked = now_;
    desk.first_expected.reset();
    if (desk.wish.ahead) {
      const WallTime start = now_ + desk.wish.lead;
      const auto booking =
          scheduler_.Book(user, kClass, {start, start + desk.wish.length + minutes(3)}, now_);
      if (booking.ok()) {
        desk.booking = booking.value().id;
        desk.mood = Mood::kWaitsForBooking;
        return;
      }
    }
    TicketRequest request;
    request.user = user;
    request.rig_class = kClass;
    request.min = std::min<Milliseconds>(desk.wish.length, minutes(10));
    request.want = desk.wish.length + minutes(2);
    const auto answer = scheduler_.RequestTicket(request, now_);
    if (!answer.ok() || !std::holds_alternative<Ticket>(answer.value())) {
      Rethink(desk);
      return;
    }
    desk.ticket = std::get<Ticket>(answer.value()).id;
    desk.first_expected = std::get<Ticket>(answer.value()).first_expected;
    desk.mood = Mood::kQueues;
  }

  void WaitForBooking(Desk& desk, UserId user) {
    const auto booking = scheduler_.state().bookings.find(desk.booking);
    if (booking == scheduler_.state().bookings.end()) {
      Rethink(desk);  // no-show, or no rig was available
    } else if (booking->second.state == BookingState::kHeld && !desk.wish.no_show) {
      desk.asked = booking->second.during.start;
      const auto session = scheduler_.ClaimBooking(desk.booking, user, now_);
      if (session.ok()) Begin(desk, session.value());
    }
  }

  void Begin(Desk& desk, const Session& session) {
    desk.mood = Mood::kWorks;
    desk.session = session.id;
    desk.began = now_;
    desk.until = now_ + desk.wish.length;
    ++tally_.served;
    tally_.waits_min.push_back(Seconds(now_ - desk.asked) / 60.0);
    if (desk.wish.ahead || !desk.first_expected) return;
    const auto day = (desk.asked - kMonday) / hours(24);
    const Milliseconds told = std::max(Milliseconds{0}, *desk.first_expected - desk.asked);
    days_[day] = days_[day] || now_ - desk.asked > 2 * told + minutes(2);
  }

  void Work(Desk& desk) {
    const auto session = scheduler_.state().sessions.find(desk.session);
    const bool ended = session == scheduler_.state().sessions.end() ||
                       session->second.state == SessionState::kClosed;
    if (!ended) Must(scheduler_.ControlActivity(desk.session, session->second.epoch, now_));
    if (!ended && now_ < desk.until) return;
    const WallTime useful_end = std::min(now_, desk.until);
    tally_.got_s[desk.wish.user] += Seconds(useful_end - desk.began);
    tally_.useful_open_s += OpenSeconds(desk.began, useful_end);
    if (!ended) Must(scheduler_.EndSession(desk.session, EndReason::kEnded, "done", now_));
    Rethink(desk);
  }

  void Rethink(Desk& desk) { desk = Desk{people_.Next(desk.wish.user, now_)}; }

  void Checks() {
    for (auto entry = checks_.begin(); entry != checks_.end();) {
      if (entry->second.second > now_) {
        ++entry;
        continue;
      }
      Must(scheduler_.CleaningDone(entry->first, entry->second.first, true, "", now_));
      entry = checks_.erase(entry);
    }
  }

  void Account() {
    for (const auto& [id, rig] : scheduler_.state().rigs) {
      if (rig.status != RigStatus::kCleaning || seen_epochs_[id] == rig.epoch) continue;
      seen_epochs_[id] = rig.epoch;
      checks_[id] = {rig.epoch, now_ + people_.Check()};
    }
    (void)scheduler_.TakeNotices();
    for (const Session& session : scheduler_.TakeChanges().sessions) {
      if (session.end_reason == EndReason::kNoShow) {
        tally_.lost_s += OpenSeconds(session.start, now_);
      }
    }
  }

  const int weeks_;
  People people_;
  Scheduler scheduler_;
  WallTime now_ = kMonday;
  std::vector<Desk> desks_;
  std::map<RigId, std::pair<std::uint64_t, WallTime>> checks_;
  std::map<RigId, std::uint64_t> seen_epochs_;  ///< epochs of the checks that have begun
  std::map<std::int64_t, bool> days_;
  Tally tally_;
};

/// Each request takes whole slots on the first rig that is free at the next slot border, in the
/// order of the requests; a booking takes the first slots at or after its hour. A no-show wastes
/// its slots.
WeekFigures FixedSlots(int weeks, std::uint64_t seed) {
  People people(seed);
  Tally tally;
  std::vector<Wish> wishes;
  for (int user = 0; user < kUsers; ++user) wishes.push_back(people.Next(user, kMonday));
  std::map<int, std::map<WallTime, bool>> taken;  // rig -> slot start
  const WallTime end = kMonday + hours(24 * 7 * weeks);
  while (true) {
    auto next = std::min_element(
        wishes.begin(), wishes.end(), [](const Wish& a, const Wish& b) { return a.at < b.at; });
    const Wish wish = *next;
    if (wish.at >= end) break;
    ++tally.wishes;
    const WallTime wanted = wish.ahead ? wish.at + wish.lead : wish.at;
    const auto slots = (wish.length + seconds(20) + kSlot - Milliseconds{1}) / kSlot;
    const auto since = wanted - kMonday;
    WallTime start = kMonday + (since + kSlot - Milliseconds{1}) / kSlot * kSlot;
    int rig = -1;
    for (; rig < 0; start += kSlot) {
      for (int candidate = 0; candidate < kRigs && rig < 0; ++candidate) {
        bool free = true;
        for (int k = 0; k < slots; ++k)
          free = free && !taken[candidate].contains(start + k * kSlot);
        if (free) rig = candidate;
      }
      if (rig >= 0) break;
    }
    for (int k = 0; k < slots; ++k) taken[rig][start + k * kSlot] = true;
    const WallTime over = start + wish.length;
    if (wish.no_show) {
      tally.lost_s += OpenSeconds(start, start + slots * kSlot);
    } else if (over < end) {
      ++tally.served;
      tally.waits_min.push_back(Seconds(start - wanted) / 60.0);
      tally.useful_open_s += OpenSeconds(start, over);
    }
    *next = people.Next(wish.user, wish.no_show ? start + kSlot : over);
  }
  return tally.Figures(weeks);
}

}  // namespace

void SimulateWeeks(int weeks, std::uint64_t seed, RehearsalReport& report) {
  if (weeks <= 0) return;
  OurWeek(weeks, seed).Run(report);
  report.fifo_slots = FixedSlots(weeks, seed);
}

}  // namespace faultlab::server::lab
