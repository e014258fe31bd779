#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "server/lab/lab_store.h"
#include "server/lab/lab_types.h"
#include "server/lab/scheduler.h"
#include "tests/world/rehearsed_rig.h"

namespace faultlab::server::lab::rehearsal {

/// What anybody can read: rigs, tickets, bookings, sessions and planned outages.
struct Published {
  explicit Published(const LabState& state)
      : rigs(state.rigs),
        tickets(state.tickets),
        bookings(state.bookings),
        sessions(state.sessions),
        outages(state.outages),
        windows(state.windows) {}
  const std::map<RigId, Rig>& rigs;
  const std::map<TicketId, Ticket>& tickets;
  const std::map<BookingId, Booking>& bookings;
  const std::map<SessionId, Session>& sessions;
  const std::map<OutageId, Outage>& outages;
  const std::map<WindowId, Window>& windows;
};

/// The courses of the people of a world.
inline Courses CoursesOf(UserId user) {
  const std::int64_t course = Number(user) % 3;
  return course == 0 ? Courses{} : Courses{course};
}

/// When and by whom something was answered.
struct Moment {
  WorldTime at{};      ///< the same clock for everybody
  WallTime lab{};      ///< the server's time, as in its answer
  std::string member;  ///< which server
};

/// Judges what the lab publishes by the rules of server/lab/README.md. Has its own numbers, knows
/// nothing of the scheduler, and remembers only what was published, requested or seen at a rig.
class Oracle {
 public:
  /// What is wrong by one rule.
  struct Findings {
    std::int64_t count = 0;
    std::string first;
  };

  /// Whether servers share the store, so that a member's lease is 10 s; what the policy allows all
  /// extensions of one session together.
  Oracle(bool shared, Milliseconds extended_max) : shared_(shared), extended_max_(extended_max) {}

  // Said by the world, because people would know it.
  /// A server, the store or a clock is in trouble until then: deadlines may be missed so long, and
  /// a held rig may be taken back.
  void Trouble(WorldTime until);
  /// A rig of this class is taken from people.
  void RigTrouble(const std::string& rig_class, WorldTime at);
  /// The clock of the only server was set to another hour.
  void ClockWasSet(WorldTime at) { clock_set_ = at; }
  void FarRig(const RigId& rig) { far_.insert(rig); }

  // Published.
  void Told(const std::vector<LabEvent>& messages, WorldTime at);
  /// After an answer of a server: what a GET shows now.
  void Shown(const Published& published, const Moment& moment);

  // Requests that were accepted, before the answer is judged by Shown.
  void AskedToEnd(SessionId session) { asked_to_end_.insert(session); }
  void AskedToExtend(SessionId session) { asked_to_extend_.insert(session); }
  void AskedToLeave(TicketId ticket) { asked_to_leave_.insert(ticket); }
  void AskedToCancel(BookingId booking) { asked_to_cancel_.insert(booking); }
  void AskedToQuarantine(const RigId& rig) { rigs_[rig].failed = true; }
  void OfferedControl(SessionId session, UserId to) { offered_[session] = to; }
  void TookOver(SessionId session, UserId by) { took_over_[session] = by; }
  void Active(SessionId session, WorldTime at);
  void RunBegan(SessionId session) { ++runs_[session]; }
  void RunEnded(SessionId session, WorldTime at);
  /// Its server died.
  void RunCut(SessionId session) { --runs_[session]; }
  // Answers that a rule forbids.
  /// A person asked for a rig. The answer before Shown tells what it has led to.
  void Answered(UserId user,
                const std::string& rig_class,
                const TicketAnswer& answer,
                const Published& now);
  void Broken(const std::string& rule, const std::string& text);

  // At the rigs.
  void CheckBegan(const RigId& rig, std::uint64_t epoch, WorldTime at);
  void CheckEnded(const RigId& rig, std::uint64_t epoch, bool passed, WorldTime at);
  /// The rig has accepted what `sender` sent.
  void Accepted(const RigId& rig, std::uint64_t epoch, const Sender& sender);

  /// The number of answers so far.
  std::int64_t answers() const { return answers_; }
  /// By rule: "hard end".
  const std::map<std::string, Findings>& findings() const { return findings_; }
  std::int64_t sessions() const { return sessions_begun_; }

 private:
  struct Known {
    Session last;
    WorldTime seen{};      ///< first shown
    WorldTime since{};     ///< not before: the answer before that
    WorldTime deadline{};  ///< hard_end on the world's clock
    WorldTime active_since{};
    WorldTime last_activity{};
    bool warned = false;
    bool troubled = false;  ///< a server was in trouble meanwhile: its use may not be charged
    std::optional<WorldTime> idle_asked;
    Milliseconds extended{};  ///< by all its extensions, as shown
    int near_end = 0;         ///< answers in the last 5 minutes
    bool extendable = false;  ///< by the last answer: nobody waits and nothing begins
    Courses courses{};        ///< of who got it
  };
  struct KnownBooking {
    Booking last;
    std::optional<WorldTime> due;  ///< shown as due and without a rig since
    int beside_ready = 0;          ///< answers that showed it so beside a ready rig
    int on_dead_rig = 0;           ///< answers that showed it there though an equal rig is free
    int waits_for_free = 0;        ///< answers that showed it so though a rig is free in its time
  };
  struct KnownTicket {
    Ticket last;
    WorldTime created{};
  };
  struct KnownRig {
    std::uint64_t highest_lease = 0;  ///< of sessions and checks
    std::uint64_t newest_check = 0;   ///< begun at the rig
    bool checked = false;             ///< its newest check passed, and nobody had it since
    bool failed = false;              ///< a check failed, or an operator took it out
    RigStatus status = RigStatus::kOffline;
    std::uint64_t epoch = 0;
    WorldTime status_since{};  ///< of this status and epoch
  };
  struct Lease {
    SessionId session{};
    UserId user{};
    std::optional<WorldTime> over;  ///< shown as ended
    /// Members that have answered since, and the number of that answer.
    std::map<std::string, std::int64_t> known_to{};
  };
  struct Use {
    double most_s = 0.0;
    double least_s = 0.0;
  };

  bool Excused(WorldTime at) const { return at <= trouble_until_; }
  bool RigsExcused(const std::string& rig_class, WorldTime at) const;
  void JudgeSessions(const Published& now, const Moment& moment);
  void JudgeNew(const Session& session, const Published& now);
  void JudgeLease(Known& known, const Session& session, const Moment& moment);
  static BookingId OwnNext(const Published& now, const Session& session);
  void JudgeEnd(Known& known, const Session& session, const Published& now, const Moment& moment);
  void JudgeGone(SessionId id, Known& known, const Published& now, const Moment& moment);
  void JudgeRigs(const Published& now, const Moment& moment);
  void JudgeBookings(const Published& now, const Moment& moment);
  void JudgeTickets(const Published& now, const Moment& moment);
  void JudgeOrder(const Published& now, const Moment& moment);
  void EndLease(const RigId& rig, std::uint64_t epoch, const Moment& moment);
  void Charge(const Known& known, WorldTime at, bool surely);
  static bool KeepsPlace(const KnownTicket& ticket, const Moment& moment, Milliseconds slack);
  double MostScore(const KnownTicket& ticket, WorldTime at) const;
  double LeastScore(const KnownTicket& ticket, WorldTime at) const;
  WallTime NextOn(const Published& now,
                  const RigId& rig,
                  WallTime from,
                  BookingId without = {}) const;
  const std::vector<Interval>& ShutOf(const Published& now,
                                      const std::string& rig_class,
                                      const Courses& courses);
  WallTime ShutFrom(const Published& now,
                    const std::string& rig_class,
                    const Courses& courses,
                    WallTime from);
  WallTime OpenFrom(const Published& now,
                    const std::string& rig_class,
                    const Courses& courses,
                    WallTime from);
  bool Fits(const Published& now, const Rig& rig, const Ticket& ticket, WallTime lab);
  void JudgeWaiting(const Published& now, const Moment& moment);
  bool EqualRigIsFree(const Published& now, const Booking& booking, WallTime lab) const;
  bool IsDue(const Published& now, UserId user, const std::string& rig_class, WallTime lab) const;
  bool HasSession(const Published& now, UserId user, const std::string& rig_class) const;

  const bool shared_;
  const Milliseconds extended_max_;
  std::map<std::string, Findings> findings_;
  std::int64_t sessions_begun_ = 0;
  WorldTime trouble_until_{-1};
  std::map<std::string, WorldTime> rig_trouble_;
  std::optional<WorldTime> clock_set_;  ///< newest
  std::set<RigId> far_;
  std::map<SessionId, Known> known_;
  std::map<std::pair<std::string, Courses>, std::vector<Interval>> shut_;  ///< by these hours
  std::vector<WindowId> shut_by_;
  std::map<BookingId, KnownBooking> bookings_;
  std::map<TicketId, KnownTicket> tickets_;
  std::map<RigId, KnownRig> rigs_;
  std::map<RigId, std::map<std::uint64_t, Lease>> leases_;
  std::map<UserId, Use> used_;
  std::map<std::string, WorldTime> answered_;  ///< of each member, newest
  WorldTime last_answer_{};
  std::int64_t answers_ = 0;
  std::map<SessionId, std::string> end_topics_;
  std::map<SessionId, std::string> end_texts_;
  std::set<SessionId> told_extended_;   ///< since the last answer
  std::set<SessionId> told_shortened_;  ///< since the last answer
  std::map<UserId, int> told_unfulfilled_;
  std::map<UserId, int> told_time_;  ///< that a time is theirs, or has begun without a rig
  std::vector<std::pair<RigId, std::uint64_t>> just_over_;  ///< leases
  std::vector<SessionId> just_begun_;                       ///< in this answer
  std::set<SessionId> asked_to_end_;
  std::set<SessionId> asked_to_extend_;
  std::set<TicketId> asked_to_leave_;
  std::set<BookingId> asked_to_cancel_;
  std::map<SessionId, UserId> offered_;
  std::map<SessionId, UserId> took_over_;
  std::map<SessionId, int> runs_;
  std::set<TicketId> served_;
};

}  // namespace faultlab::server::lab::rehearsal
