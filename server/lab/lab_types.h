#pragma once

#include <chrono>
#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/wall_time.h"

namespace faultlab::server::lab {

using Milliseconds = std::chrono::milliseconds;
using RigId = std::string;

enum class UserId : std::int64_t {};
enum class TicketId : std::int64_t {};
enum class BookingId : std::int64_t {};
enum class SessionId : std::int64_t {};
enum class OutageId : std::int64_t {};
enum class WindowId : std::int64_t {};

template <typename Id>
constexpr std::int64_t Number(Id id) {
  return static_cast<std::int64_t>(id);
}

/// Half-open: [start, end).
struct Interval {
  WallTime start{};
  WallTime end{};
  bool Overlaps(const Interval& other) const { return start < other.end && other.start < end; }
  Milliseconds length() const { return end - start; }
  friend auto operator<=>(const Interval&, const Interval&) = default;
};

/// "2026-01-05 12:40 UTC", for sentences.
std::string UtcText(WallTime time);

enum class RigStatus : std::uint8_t {
  kOffline,
  kReady,
  kLeased,
  kCleaning,
  kQuarantined,
  kMaintenance
};
std::string_view Name(RigStatus status);

/// A bench or simulator, as represented in the scheduler.
struct Rig {
  RigId id;
  std::string rig_class;
  bool elastic = false;  ///< a simulator that is built anew for each lease: no queue and no check
  RigStatus status = RigStatus::kOffline;
  std::uint64_t epoch = 0;    ///< increases with every holder and every cleaning
  WallTime cleaning_due{};    ///< kCleaning: the check fails then; kOffline: no check before
  Milliseconds wear{};        ///< total time in sessions
  std::string reason;         ///< why the rig is not ready, for people
  std::string server;         ///< the member that has the rig; empty: none
  bool check_failed = false;  ///< kQuarantined: by its check, and `reason` is what the check found
  friend bool operator==(const Rig&, const Rig&) = default;
};

/// The courses of a person when they asked, ascending.
using Courses = std::vector<std::int64_t>;

/// Opening hours of a rig class, or hours that a course has it for itself (opening.h).
struct Window {
  WindowId id{};
  std::string rig_class;
  std::int64_t course = 0;  ///< whose people have the class in these times; 0: everybody
  std::string title;
  std::string repeat;           ///< as it was asked for: an RRULE of iCalendar; empty: once
  std::string time_zone;        ///< of that, by its IANA name
  std::vector<Interval> times;  ///< in order, none overlaps another
  friend bool operator==(const Window&, const Window&) = default;
};

/// A planned time in which a rig is not available.
struct Outage {
  OutageId id{};
  RigId rig;
  Interval during;
  std::string reason;
  /// Whose bookings it has cancelled, and when those were: WriteFallen() in notices.h.
  std::string fallen;
  friend bool operator==(const Outage&, const Outage&) = default;
};

enum class TicketState : std::uint8_t { kWaiting, kOffered, kClaimed, kExpired, kLeft };
std::string_view Name(TicketState state);
/// kPractice: one run on an elastic simulator, without a ticket (rule 11).
enum class TicketKind : std::uint8_t { kPerson, kJob, kPractice };

/// A place in the queue of a rig class.
struct Ticket {
  TicketId id{};
  UserId user{};
  std::string rig_class;
  TicketKind kind = TicketKind::kPerson;
  std::string job;      ///< kJob: what to run
  double weight = 0.0;  ///< class weight of the order, see FairScore
  Milliseconds min{};   ///< shortest useful session
  Milliseconds want{};  ///< longest requested session
  WallTime created{};
  TicketState state = TicketState::kWaiting;
  SessionId offered{};  ///< kOffered, kClaimed: the session that holds the rig
  int offers_missed = 0;
  int place = 0;                     ///< 1 = next; 0 when not waiting
  std::optional<WallTime> expected;  ///< newest estimate of the start; nullopt: no rig is expected
  std::optional<WallTime> first_expected;  ///< the first estimate sent to the user
  Courses courses;
  friend bool operator==(const Ticket&, const Ticket&) = default;
};

enum class BookingState : std::uint8_t {
  kBooked,
  kHeld,  ///< due: a rig is held for the user during the grace time
  kClaimed,
  kNoShow,
  kCancelled,
  kUnfulfilled,  ///< no rig was available; credited
  kDone,
  kWaiting  ///< for a time that others have; no rig is planned
};
std::string_view Name(BookingState state);

/// A session on a rig of a class, promised in advance. `rig` is the plan and may change until the
/// start.
struct Booking {
  BookingId id{};
  UserId user{};
  std::string rig_class;
  Interval during;
  BookingState state = BookingState::kBooked;
  RigId rig;
  SessionId session{};
  std::int64_t version = 1;
  std::string note;  ///< why it was moved or cancelled, for the user
  Courses courses;
  friend bool operator==(const Booking&, const Booking&) = default;
};
bool IsLive(const Booking& booking);

enum class SessionState : std::uint8_t { kHeld, kActive, kClosed };
std::string_view Name(SessionState state);
enum class EndReason : std::uint8_t {
  kNone,
  kEnded,  ///< ended by the user
  kExpired,
  kIdle,
  kNoShow,       ///< booking not claimed in the grace time
  kOfferMissed,  ///< offer not accepted in time
  kRigFailed,
  kOperator,
  kBooking  ///< the user's own booking begins on another rig
};
std::string_view Name(EndReason reason);

/// A lease of one rig. kHeld: reserved for a due booking or an offered ticket, no command possible.
struct Session {
  SessionId id{};
  UserId user{};
  RigId rig;
  std::string rig_class;
  std::uint64_t epoch = 0;  ///< of its lease; 0 while held
  BookingId booking{};
  TicketId ticket{};
  TicketKind kind = TicketKind::kPerson;
  std::string job;  ///< kJob: what it runs
  SessionState state = SessionState::kHeld;
  WallTime start{};
  WallTime hard_end{};
  WallTime claim_until{};  ///< kHeld
  WallTime last_control{};
  WallTime charged_from{};
  bool run_in_progress = false;
  Milliseconds extended{};  ///< by how much automatic extensions have moved its end
  int warning_stage = 0;    ///< 0 none, 1 = 5 min, 2 = 1 min, 3 = 30 s
  std::optional<WallTime> idle_answer_until;
  UserId offered_to{};  ///< user to whom control was offered
  EndReason end_reason = EndReason::kNone;
  std::string end_text;
  std::optional<WallTime> ended;  ///< kClosed
  Courses courses;                ///< of who got it
  friend bool operator==(const Session&, const Session&) = default;
};

/// Past use of one user, decaying with the policy's half-life.
struct Usage {
  UserId user{};
  double seconds = 0.0;
  WallTime at{};
  std::int64_t week = 0;     ///< WeekOf the newest use
  Milliseconds this_week{};  ///< use in that week, for PolicySettings::week_max
  friend bool operator==(const Usage&, const Usage&) = default;
};

/// Something to tell a user, stored with the transition that caused it.
struct Notice {
  UserId user{};
  SessionId session{};
  std::string topic;  ///< "offer", "place", "warning", "extended", "idle", "ended", "no_show", ..
  std::string text;
  RigId rig;        ///< empty: of no certain rig
  UserId other{};   ///< who did it, or got it; none: the lab itself
  std::string why;  ///< the words of a person or of the rig; may be empty
  /// What the lab had to do it for: "limit", "queue", "booking", "outage", "hours", "rig_out",
  /// "rig_gone", "none_free", "replanned", "clock"; may be empty.
  std::string reason{};
  /// Of "warning" and "shortened" the end of the session; of a booking its start.
  std::optional<WallTime> time{};
};

/// What an admin may change while the lab runs; stored with the state. kPolicySettings in
/// policy_settings.h lists the names and limits.
struct PolicySettings {
  std::int64_t version = 0;     ///< rises with each change; 0: never changed
  Milliseconds offer{45'000};   ///< to accept an offered rig
  Milliseconds grace{180'000};  ///< to claim a due booking
  Milliseconds extend_step{600'000};
  Milliseconds extended_max{std::chrono::hours(4)};  ///< of all extensions of one session
  Milliseconds idle{180'000};
  Milliseconds idle_answer{60'000};
  Milliseconds session_min{300'000};
  Milliseconds session_max{7'200'000};  ///< of one ticket; extensions are added to it
  Milliseconds booking_min{300'000};
  Milliseconds booking_max{14'400'000};
  Milliseconds booking_ahead{std::chrono::hours(24 * 60)};
  Milliseconds no_show_charge{600'000};
  Milliseconds week_max{};  ///< on real rigs, per user and calendar week (UTC); 0: no limit
  int live_bookings_max = 3;
  int waiting_jobs_max = 64;  ///< per user and class
  friend bool operator==(const PolicySettings&, const PolicySettings&) = default;
};

/// All numbers of the rules. Those outside PolicySettings are properties of the lab's machines and
/// of its order, the same for all members.
struct Policy : PolicySettings {
  Milliseconds member_lease{10'000};   ///< a server that is silent for longer is removed
  Milliseconds cleaning{30'000};       ///< reserved on the timeline behind every session
  Milliseconds cleaning_max{120'000};  ///< longer than this: quarantine
  Milliseconds check_pause{10'000};    ///< between checks that a rig does not let begin
  Milliseconds heal_ahead{900'000};
  Milliseconds given_ahead{900'000};  ///< a time that somebody waits for is not given later
  Milliseconds half_life{std::chrono::hours(24 * 7)};
  double job_weight_s = -21'600.0;  ///< a job is treated as if it had come six hours later
  double age_weight_per_s = 1.0;
  double fresh_user_bonus_s = 1800.0;   ///< bonus of a user without past use
  double use_quota_s = 7200.0;          ///< past use that halves the bonus
  Milliseconds asked_together{60'000};  ///< among those who ask within this time the score decides
  Milliseconds keeps_place{900'000};    ///< whose first estimate is so near is not overtaken
};

/// Everything that has not ended. Ended things are removed after TakeChanges().
struct LabState {
  std::map<RigId, Rig> rigs;
  std::map<OutageId, Outage> outages;
  std::map<WindowId, Window> windows;
  std::map<TicketId, Ticket> tickets;
  std::map<BookingId, Booking> bookings;
  std::map<SessionId, Session> sessions;
  std::map<UserId, Usage> usage;
  /// What somebody has changed: "" of the lab, else of a rig class that has settings of its own.
  std::map<std::string, PolicySettings> settings;
  std::int64_t next_id = 1;
  friend bool operator==(const LabState&, const LabState&) = default;
};

}  // namespace faultlab::server::lab
