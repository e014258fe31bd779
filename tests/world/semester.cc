#include "tests/world/semester.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "core/types/check.h"
#include "tests/world/memory_store.h"
#include "tests/world/people.h"

namespace faultlab::server::lab::rehearsal {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

constexpr WorldTime kStep = seconds(5);
constexpr WorldTime kNightStep = seconds(60);
constexpr const char* kClass = "bench";
/// A wait that is promised as short as this may be so much longer: a check, and people who react.
constexpr Milliseconds kTolerance = minutes(2);

/// The people in the lab as it ships.
class Semester {
 public:
  Semester(int weeks, std::uint64_t seed, bool timetable)
      : weeks_(weeks), people_(seed), site_(seed, scratch_, false, true, kExtended) {
    for (int i = 0; i < kSemesterRigs; ++i) {
      WorldRig rig;
      rig.description.id = "bench-" + std::to_string(i);
      rig.description.rig_class = kClass;
      rig.description.kind = hardware::RigKind::kBench;
      rig.member = "lab";
      rig.body = std::make_shared<RigBody>(rig.description.id, [](const RigId&, std::uint64_t) {});
      site_.rigs.push_back(std::move(rig));
    }
    memory_->keep_events = false;
    LAB_CHECK(lab_.Start(), "lab");
    if (timetable) SetHours();
    for (int user = 0; user < kSemesterUsers; ++user) {
      desks_.push_back({people_.Next(user, kWorldStart)});
    }
  }

  void Run(RehearsalReport& report) {
    const WorldTime end = hours(24 * 7 * weeks_);
    while (site_.now < end) {
      const auto state = lab_.state();
      const bool quiet = !IsOpen(Now()) && state->bookings.empty() &&
                         std::all_of(state->rigs.begin(), state->rigs.end(), [](const auto& rig) {
                           return rig.second.status == RigStatus::kReady;
                         });
      site_.now += quiet ? kNightStep : kStep;
      lab_.Turn();
      for (Desk& desk : desks_) Live(desk);
    }
    report.ours = tally_.Figures(weeks_);
    report.jain = report.ours.jain;
    int held = 0;
    for (const auto& [day, broken] : days_) held += broken ? 0 : 1;
    report.days_estimate_held = days_.empty() ? 1.0 : held / static_cast<double>(days_.size());
    for (const auto& [rule, found] : site_.oracle.findings()) {
      auto& kept = report.broken_rules[rule];
      if (kept.count == 0) kept.first = "semester: " + rule + ": " + found.first;
      kept.count += found.count;
      if (report.first_broken.empty()) report.first_broken = kept.first;
      report.broken_invariants += found.count;
    }
  }

 private:
  /// Open from Monday to Sunday when people come; a double hour on two days for each course.
  void SetHours() {
    lab_.Turn();  // it brings its rigs
    const auto add = [&](std::int64_t course, int every_days, Milliseconds from, Milliseconds to) {
      Window window;
      window.rig_class = kClass;
      window.course = course;
      window.title = "hours";
      for (int day = static_cast<int>(course); day < 7 * weeks_; day += every_days) {
        const WallTime midnight = kWorldStart + hours(24) * day;
        window.times.push_back({midnight + from, midnight + to});
      }
      const auto added =
          lab_.Do([&](Scheduler& lab, WallTime now) { return lab.AddWindow(window, now); });
      LAB_CHECK(added && added->ok(), course);
    };
    add(0, 1, kOpens, kCloses + minutes(30));
    for (const std::int64_t course : {1, 2}) add(course, 3, hours(10), hours(12));
  }

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

  WallTime Now() const { return kWorldStart + site_.now; }
  static UserId UserOf(const Desk& desk) { return UserId{desk.wish.user + 1}; }

  void Live(Desk& desk) {
    switch (desk.mood) {
      case Mood::kThinks:
        if (Now() >= desk.wish.at) Ask(desk);
        break;
      case Mood::kQueues:
        Queue(desk);
        break;
      case Mood::kReacts:
        if (Now() >= desk.until) Accept(desk);
        break;
      case Mood::kWaitsForBooking:
        WaitForBooking(desk);
        break;
      case Mood::kWorks:
        Work(desk);
        break;
    }
  }

  void Ask(Desk& desk) {
    ++tally_.wishes;
    desk.asked = Now();
    if (desk.wish.ahead) {
      const WallTime start = Now() + desk.wish.lead;
      const Interval during{start, start + desk.wish.length + minutes(3)};
      const auto booked = lab_.Do([&](Scheduler& lab, WallTime now) {
        return lab.Book(UserOf(desk), kClass, during, now, CoursesOf(UserOf(desk)));
      });
      if (booked && booked->ok()) {
        desk.booking = booked->value().id;
        desk.mood = Mood::kWaitsForBooking;
        return;
      }
    }
    TicketRequest request;
    request.user = UserOf(desk);
    request.rig_class = kClass;
    request.courses = CoursesOf(UserOf(desk));
    request.min = std::min<Milliseconds>(desk.wish.length, minutes(10));
    request.want = desk.wish.length + minutes(2);
    const auto answer =
        lab_.Do([&](Scheduler& lab, WallTime now) { return lab.RequestTicket(request, now); });
    const bool waits = answer && answer->ok() && std::holds_alternative<Ticket>(answer->value());
    if (!waits) return Rethink(desk);
    const Ticket& ticket = std::get<Ticket>(answer->value());
    desk.ticket = ticket.id;
    desk.first_expected = ticket.first_expected;
    desk.mood = Mood::kQueues;
  }

  void Queue(Desk& desk) {
    const auto state = lab_.state();
    const auto ticket = state->tickets.find(desk.ticket);
    if (ticket == state->tickets.end()) return Rethink(desk);
    if (!desk.first_expected) desk.first_expected = ticket->second.first_expected;
    if (ticket->second.state != TicketState::kOffered) return;
    desk.mood = Mood::kReacts;
    desk.until = Now() + people_.Reaction(desk.wish.user);
  }

  void Accept(Desk& desk) {
    const auto session = lab_.Do([&](Scheduler& lab, WallTime now) {
      return lab.AcceptTicket(desk.ticket, UserOf(desk), now);
    });
    if (session && session->ok()) return Begin(desk, session->value());
    desk.mood = Mood::kQueues;
  }

  void WaitForBooking(Desk& desk) {
    const auto state = lab_.state();
    const auto booking = state->bookings.find(desk.booking);
    if (booking == state->bookings.end()) return Rethink(desk);
    if (booking->second.state != BookingState::kHeld) return;
    if (desk.wish.no_show) {
      if (desk.session == SessionId{}) desk.began = Now();
      desk.session = booking->second.session;
      return;
    }
    desk.asked = booking->second.during.start;
    const auto session = lab_.Do([&](Scheduler& lab, WallTime now) {
      return lab.ClaimBooking(desk.booking, UserOf(desk), now);
    });
    if (session && session->ok()) Begin(desk, session->value());
  }

  void Begin(Desk& desk, const Session& session) {
    desk.mood = Mood::kWorks;
    desk.session = session.id;
    desk.began = Now();
    desk.until = Now() + desk.wish.length;
    ++tally_.served;
    const Milliseconds waited = Now() - desk.asked;
    tally_.waits_min.push_back(std::chrono::duration<double>(waited).count() / 60.0);
    if (!desk.first_expected) return;
    const auto day = (desk.asked - kWorldStart) / hours(24);
    const Milliseconds told = std::max(Milliseconds{0}, *desk.first_expected - desk.asked);
    days_[day] = days_[day] || waited > 2 * told + kTolerance;
  }

  void Work(Desk& desk) {
    const auto state = lab_.state();
    const auto session = state->sessions.find(desk.session);
    const bool ended = session == state->sessions.end();
    if (!ended && Now() < desk.until) {
      if (Now() - session->second.last_control < minutes(2)) return;
      const auto active = lab_.Do([&, epoch = session->second.epoch](Scheduler& lab, WallTime now) {
        return lab.ControlActivity(desk.session, epoch, now);
      });
      if (active && active->ok()) site_.oracle.Active(desk.session, site_.now);
      return;
    }
    tally_.Work(desk.wish.user, desk.began, std::min(Now(), desk.until));
    if (!ended) {
      site_.oracle.AskedToEnd(desk.session);
      (void)lab_.Do([&](Scheduler& lab, WallTime now) {
        return lab.EndSession(desk.session, EndReason::kEnded, "done", now);
      });
    }
    Rethink(desk);
  }

  void Rethink(Desk& desk) {
    const bool lost = desk.wish.no_show && desk.session != SessionId{};
    if (lost) tally_.Lose(desk.began, Now());
    desk = Desk{people_.Next(desk.wish.user, Now())};
  }

  const int weeks_;
  RehearsalReport scratch_;
  People people_;
  Site site_;
  std::shared_ptr<MemoryLab> memory_ = std::make_shared<MemoryLab>();
  WorldMember lab_{site_, "lab", [this]() -> std::unique_ptr<LabStore> {
                     return std::make_unique<MemoryStore>(memory_, false, [this] { return Now(); });
                   }};
  std::vector<Desk> desks_;
  std::map<std::int64_t, bool> days_;
  Tally tally_;
};

}  // namespace

void SimulateSemester(int weeks, std::uint64_t seed, bool timetable, RehearsalReport& report) {
  if (weeks <= 0) return;
  Semester(weeks, seed, timetable).Run(report);
  report.fifo = FirstInFirstOut(weeks, seed);
  report.fifo_slots = FixedSlots(weeks, seed);
}

}  // namespace faultlab::server::lab::rehearsal
