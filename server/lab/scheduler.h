#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/types/result.h"
#include "server/lab/lab_types.h"

namespace faultlab::server::lab {

struct TicketRequest {
  UserId user{};
  std::string rig_class;
  TicketKind kind = TicketKind::kPerson;
  std::string job;
  double weight = 0.0;
  Milliseconds min{std::chrono::minutes(10)};
  Milliseconds want{std::chrono::minutes(30)};
  Courses courses{};  ///< in whose hours it may be
};

/// The answer to a request for a rig: the user's own live session (rule 4), or a ticket.
using TicketAnswer = std::variant<Session, Ticket>;

/// What has changed since the last TakeChanges(), to be stored in one transaction. Ended things
/// appear here once, in their last state.
struct Changes {
  std::vector<Rig> rigs;
  std::vector<Outage> outages;
  std::vector<OutageId> ended_outages;
  std::vector<Window> windows;
  std::vector<WindowId> ended_windows;
  std::vector<Ticket> tickets;
  std::vector<Booking> bookings;
  std::vector<Session> sessions;
  std::vector<Usage> usage;
  std::map<std::string, std::optional<PolicySettings>> settings;  ///< of a class; nullopt: none
  std::int64_t next_id = 1;
  bool empty() const;
};

/// A rig's reason after a failed check begins with this.
inline constexpr std::string_view kCheckFailedText = "the check between users failed: ";

/// The lab's rules as a state machine (rules 1-14 of the README). Pure: no clock, no randomness, no
/// I/O; `now` comes with every input and never decreases, except by ClockJumped. A refused input
/// changes nothing. The duties of the servers follow from the state: a rig refuses epochs below its
/// own, and a rig in kCleaning is checked. Messages to users are returned as notices. An input for
/// a thing that does not exist gives kNotFound.
class Scheduler {
 public:
  /// Settings in the state replace those of `policy`.
  explicit Scheduler(Policy policy = {}, LabState state = {});

  const LabState& state() const { return state_; }
  const Policy& policy() const { return policy_; }

  /// From now on. What has been promised stays: bookings keep their times, sessions their ends.
  /// kStale when `settings.version` is not the newest one.
  /// @param rig_class  which has these from now on, whatever the lab has; empty: the lab
  core::Result<PolicySettings> ChangePolicy(PolicySettings settings,
                                            WallTime now,
                                            const std::string& rig_class = "");
  /// The class has the lab's settings again.
  core::Status DropPolicy(const std::string& rig_class, WallTime now);
  /// What holds for a class. Its limits count what a person has in the whole lab.
  const PolicySettings& SettingsOf(const std::string& rig_class) const;
  /// Time on real rigs in the week of `at`: used, and promised by sessions and bookings; not what
  /// is waited for.
  Milliseconds WeekUse(UserId user, WallTime at) const;

  // Rigs. A rig enters as kOffline; Claim starts its cleaning, and only a passed check gives
  // kReady.
  core::Status AddRig(const RigId& id, const std::string& rig_class, bool elastic);
  /// The member `server` receives this rig and has it from now on, unless another member has it
  /// (kConflict). The rig is checked before anybody gets it.
  core::Status Claim(const RigId& rig, const std::string& server, WallTime now);
  /// The rig plays a run that nobody holds any more, as its server died: the lease gets a new
  /// epoch, which ends that run. The session goes on. No effect on a rig that is not leased.
  core::Status RenewLease(const RigId& rig, WallTime now);
  /// Member `server` is gone: its rigs go offline and may be claimed, sessions on them end,
  /// bookings move or are cancelled.
  void MemberGone(const std::string& server, WallTime now);
  /// The rig then belongs to no member.
  core::Status RigOffline(const RigId& rig, const std::string& reason, WallTime now);
  /// kStale when `epoch` is not that of the check in progress.
  core::Status CleaningDone(
      const RigId& rig, std::uint64_t epoch, bool passed, const std::string& detail, WallTime now);
  /// The rig did not accept the lease of this check, so its health is unknown. It waits as kOffline
  /// until Claim, and for some seconds at least.
  core::Status CheckPutOff(const RigId& rig,
                           std::uint64_t epoch,
                           const std::string& reason,
                           WallTime now);
  core::Status Quarantine(const RigId& rig, const std::string& reason, WallTime now);
  /// Ends quarantine or maintenance and starts a check.
  core::Status Release(const RigId& rig, WallTime now);
  /// Checks a ready rig once more.
  core::Status Recheck(const RigId& rig, WallTime now);
  /// The rig has seen epochs up to `seen`, which may be above this state's, as after a restore of
  /// the database. Its next epoch is above both and begins a check. A session on the rig ends
  /// uncharged. kConflict when the rig is in order.
  core::Status Adopt(const RigId& rig, std::uint64_t seen, WallTime now);
  core::Result<Outage> AddOutage(const RigId& rig,
                                 const Interval& during,
                                 const std::string& reason,
                                 WallTime now);
  /// Bookings that it has cancelled stay cancelled; their users are told that the time is free.
  core::Status RemoveOutage(OutageId id, WallTime now);

  // Opening hours and hours of courses. What has been promised stays.
  static constexpr int kWindowsMax = 100;  ///< of a class
  static constexpr int kOfCourseMax = 20;  ///< of these, of one course
  /// kConflict when it overlaps the hours of another course, or a class has kWindowsMax.
  core::Result<Window> AddWindow(Window window, WallTime now);
  core::Status RemoveWindow(WindowId id, WallTime now);

  // Queue. Asking twice returns the same ticket.
  core::Result<TicketAnswer> RequestTicket(const TicketRequest& request, WallTime now);
  core::Result<Session> AcceptTicket(TicketId id, UserId user, WallTime now);
  core::Status LeaveTicket(TicketId id, WallTime now);
  /// The job was cancelled or is done: its ticket is removed, its session ends. No effect when it
  /// has neither.
  core::Status DropJob(const std::string& job, WallTime now);

  // Calendar.
  /// Its last policy().cleaning is for the check after it.
  /// @param wait  for the time, when no rig is free then (kWaiting)
  core::Result<Booking> Book(UserId user,
                             const std::string& rig_class,
                             const Interval& during,
                             WallTime now,
                             const Courses& courses = {},
                             bool wait = false);
  /// All of them or none: kConflict "series_refused" names the first that is refused.
  core::Result<std::vector<Booking>> BookAll(UserId user,
                                             const std::string& rig_class,
                                             const std::vector<Interval>& times,
                                             WallTime now,
                                             const Courses& courses,
                                             bool wait = false);
  /// As Book refuses, but for a rig that is free then.
  core::Status CheckBooking(UserId user,
                            const std::string& rig_class,
                            const Interval& during,
                            WallTime now,
                            const Courses& courses = {}) const;
  /// `version` as last read by the caller: kStale when the booking has changed since.
  core::Status CancelBooking(BookingId id, std::int64_t version, WallTime now);
  core::Result<Session> ClaimBooking(BookingId id, UserId user, WallTime now);

  // Sessions.
  core::Status ControlActivity(SessionId id, std::uint64_t epoch, WallTime now);
  core::Status StillThere(SessionId id, WallTime now);
  core::Status RunStarted(SessionId id, WallTime now);
  core::Status RunEnded(SessionId id, WallTime now);
  core::Result<Session> Extend(SessionId id, WallTime now);
  core::Status EndSession(SessionId id, EndReason reason, const std::string& text, WallTime now);
  core::Status OfferControl(SessionId id, UserId to, WallTime now);
  /// Refused when some of the session's rest is not for the user.
  core::Result<Session> AcceptControl(SessionId id,
                                      UserId user,
                                      WallTime now,
                                      const Courses& courses = {});
  core::Result<Session> TakeOver(SessionId id,
                                 UserId instructor,
                                 const std::string& reason,
                                 WallTime now);
  /// Starts one run at once on the first ready simulator of `among` (rule 11), for `length` at
  /// most. Ends by EndPractice. kBusy when none is ready.
  core::Result<Session> Practice(UserId user,
                                 const std::vector<RigId>& among,
                                 Milliseconds length,
                                 WallTime now);
  /// No effect when the session has ended or is not a practice session.
  void EndPractice(SessionId id, WallTime now);

  /// Applies the passing of time: moves bookings off bad rigs, binds due bookings, no-shows, ends,
  /// idle, warnings, offers, estimates.
  void Tick(WallTime now);
  /// The wall clock was set, and is `now`: leases and waits keep their length, the calendar keeps
  /// its dates. Bookings that a step forward has passed over fall, and their users are told why.
  void ClockJumped(Milliseconds delta, WallTime now);
  /// Nobody could reach the lab for `length`: time limits of people and checks are extended by it.
  /// The calendar and the ends of sessions keep their dates.
  void StoodStill(Milliseconds length);
  /// After a restart of `server` (empty: of all servers): the runs on its rigs have ended; rigs
  /// that were ready or in a check are checked again.
  void Recover(WallTime now, const std::string& server = {});

  std::vector<Notice> TakeNotices();
  Changes TakeChanges();

 private:
  Rig* FindRig(const RigId& id);
  Session* FindLive(SessionId id);
  Session* LiveSessionOn(const RigId& rig);
  Session* LiveSessionOf(UserId user, const std::string& rig_class);
  Ticket* LiveTicketOf(UserId user, const std::string& rig_class);
  /// Who could have a rig of the class now.
  bool SomebodyWaits(const std::string& rig_class, WallTime now) const;

  Session& Hold(Rig& rig, UserId user, WallTime hard_end, Milliseconds claim_time, WallTime now);
  void Activate(Session& session, WallTime now);
  void Close(Session& session,
             EndReason reason,
             const std::string& text,
             WallTime now,
             const std::string& why = "");
  void StartCleaning(Rig& rig, WallTime now);
  void TakeBack(Session& session, WallTime now);
  void ToMaintenance(Rig& rig, const std::string& reason);
  /// `in_week`: it counts for PolicySettings::week_max.
  void Charge(UserId user, Milliseconds use, WallTime now, bool in_week);
  core::Status CheckWeek(UserId user,
                         const std::string& rig_class,
                         Milliseconds more,
                         WallTime at) const;
  bool IsElastic(const std::string& rig_class) const;
  /// @param why  of the end of the last one's time, as EndReasonOf tells it until the session ends
  void SwitchController(
      Session& session, UserId to, EndReason why, Notice to_the_last, WallTime now);
  void ReplanBookings(const std::string& rig_class, WallTime horizon, WallTime now);
  /// Gives the booking a rig for its time, if it must be by moving others.
  bool Plan(Booking& booking, WallTime now);
  bool GiveTime(Booking& booking, WallTime now);
  void TickWaiting(WallTime now);
  std::size_t RoomMark(WallTime now) const;
  void Unfulfil(Booking& booking, const std::string& reason, const std::string& why);
  void TellMoved(const Booking& booking, const std::string& reason, const std::string& why);
  Rig* RigForDueBooking(const Booking& booking, WallTime now);
  bool EndForBooking(Booking& booking, Session& own, WallTime now);
  WallTime UseEnd(const Booking& booking) const;
  /// Until when these people's session and the check after it may last on the rig.
  WallTime RoomUntil(const Rig& rig, const Courses& courses, WallTime from) const;
  WallTime NextCommitmentBut(const RigId& rig, WallTime from, BookingId without) const;

  void TickWindows(WallTime now);
  void TickRigs(WallTime now);
  void TickBookings(WallTime now);
  void TickSessions(WallTime now);
  void TickIdle(Session& session, WallTime now);
  void TickEnd(Session& session, WallTime now);
  std::string WhyItEnds(const Session& session) const;
  Milliseconds ExtensionLeft(const Session& session) const;
  bool GoOnIntoOwnBooking(Session& session);
  bool ExtendIfFree(Session& session, WallTime now);
  void Dispatch(WallTime now);
  bool OfferTo(Ticket& ticket, WallTime now);
  void Estimate(WallTime now);
  struct Lane;
  std::map<TicketId, std::optional<WallTime>> ExpectedStarts(std::vector<Lane> lanes,
                                                             const std::vector<TicketId>& order,
                                                             WallTime now) const;

  void Notify(UserId user, std::string topic, std::string text, SessionId session = {});
  void Notify(Notice notice);
  void Touch(const Rig& rig) { touched_rigs_.insert(rig.id); }
  void Touch(const Ticket& ticket) { touched_tickets_.insert(ticket.id); }
  void Touch(const Booking& booking) { touched_bookings_.insert(booking.id); }
  void Touch(const Session& session) { touched_sessions_.insert(session.id); }
  std::int64_t NewNumber() { return state_.next_id++; }

  Policy policy_;
  LabState state_;
  std::vector<Notice> notices_;
  std::set<RigId> touched_rigs_;
  std::set<TicketId> touched_tickets_;
  std::set<BookingId> touched_bookings_;
  std::set<SessionId> touched_sessions_;
  std::set<OutageId> touched_outages_;
  std::vector<OutageId> ended_outages_;
  std::set<WindowId> touched_windows_;
  std::vector<WindowId> ended_windows_;
  std::set<UserId> touched_users_;
  std::set<std::string> touched_settings_;  ///< classes
  std::size_t room_tried_ = 0;              ///< RoomMark when those who wait for a time were tried
};

/// The first broken invariant of a state, or empty: two sessions on a rig, two of one user in a
/// class, a lease without its rig, a ready rig with a holder, an offer without its ticket.
std::string FindBrokenInvariant(const LabState& state);

}  // namespace faultlab::server::lab
