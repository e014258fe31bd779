#pragma once

#include <chrono>

#include "server/lab/lab_types.h"

// The numbers of server/lab/README.md, as people read them. Not taken from Policy: a wrong number
// there must be found.
namespace faultlab::server::lab::rehearsal {

inline constexpr Milliseconds kOffer{45'000};
inline constexpr Milliseconds kGrace{180'000};
inline constexpr Milliseconds kCleaning{30'000};
inline constexpr Milliseconds kCleaningLongest{120'000};  ///< longer is a failed check
inline constexpr Milliseconds kIdle{180'000};
inline constexpr Milliseconds kIdleAnswer{60'000};
inline constexpr Milliseconds kExtension{600'000};  ///< of one extension, at most
/// Of all extensions of one session, by the policy as installed.
inline constexpr Milliseconds kExtended = std::chrono::hours(4);
/// The same where the admin of a random world has set it so low, to reach it often.
inline constexpr Milliseconds kExtendedInWorlds{300'000};
inline constexpr Milliseconds kExtensionLeast{60'000};  ///< less is not worth one
/// A session goes on so long at most into its user's own next booking: the check, and 5 s.
/// A time that somebody waits for is given so long before it begins, or not at all.
inline constexpr Milliseconds kGivenAhead{900'000};
inline constexpr Milliseconds kIntoOwnBooking{36'500};
inline constexpr Milliseconds kNearEnd{300'000};       ///< first warning, and first extension
inline constexpr Milliseconds kKeepsPlace{900'000};    ///< whose first estimate is so near
inline constexpr Milliseconds kAskedTogether{60'000};  ///< among these the score decides
inline constexpr Milliseconds kMemberLease{10'000};
inline constexpr double kNoShowCharge_s = 600.0;
inline constexpr double kHalfLife_s = 7.0 * 24 * 3600;
inline constexpr double kFreshBonus_s = 1800.0;  ///< of the fair order, for a user without use
inline constexpr double kQuota_s = 7200.0;       ///< use that halves the bonus

inline double Seconds(Milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

/// Tolerance of the oracle: clocks of members and the time between two answers.
inline constexpr Milliseconds kSlack{1500};
/// Longest time between two turns of the members of a world.
inline constexpr Milliseconds kChunkLongest{8000};
/// A session that has been idle for so long, while somebody waits, is not "about to be closed".
inline constexpr Milliseconds kIdleForSure{300'000};
/// A booking may have been moved for a rig in trouble so long ago: the longest time ahead in a
/// world, and the longest session.
inline constexpr Milliseconds kPlansLast = std::chrono::hours(6);
/// A booking that begins within this time is moved from a rig that does not work.
inline constexpr Milliseconds kMovedAhead{600'000};
/// A booking that is due has its rig after this time, if nothing fails.
inline constexpr Milliseconds kDueFor{10'000};
/// After this time the lab has followed a step of its clock.
inline constexpr Milliseconds kClockMoves{600'000};
/// An ended lease is watched so long for commands.
inline constexpr Milliseconds kRemembered{60'000};

}  // namespace faultlab::server::lab::rehearsal
