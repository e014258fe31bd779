#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "tests/world/random.h"
#include "tests/world/rehearsal.h"
#include "tests/world/world_member.h"

namespace faultlab::server::lab::rehearsal {

inline constexpr int kSemesterRigs = 4;
inline constexpr int kSemesterUsers = 18;
inline constexpr Milliseconds kOpens = std::chrono::hours(8);
inline constexpr Milliseconds kCloses = std::chrono::hours(20);

inline bool IsOpen(WallTime time) {
  const auto of_day = (time - kWorldStart) % std::chrono::hours(24);
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

/// Users think, request a rig, use it, and think again. All users are equal, and together they want
/// more than the rigs can serve. The n-th wish of a user is the same however the rigs are shared.
class People {
 public:
  explicit People(std::uint64_t seed) {
    for (int user = 0; user < kSemesterUsers; ++user) {
      random_.emplace_back(seed * 1000 + static_cast<std::uint64_t>(user));
    }
  }
  Wish Next(int user, WallTime after) {
    using std::chrono::hours;
    using std::chrono::minutes;
    Random& random = random_.at(static_cast<std::size_t>(user));
    Wish wish;
    wish.user = user;
    wish.at = after + random.Exponential(minutes(45));
    while (!IsOpen(wish.at)) wish.at += random.Exponential(hours(1));
    const Milliseconds worked = minutes(8) + random.Exponential(minutes(16));
    wish.length = std::min<Milliseconds>(worked, minutes(60));
    wish.ahead = random.Chance(0.25);
    wish.lead = random.Between(hours(1), hours(6));
    wish.no_show = random.Chance(0.15) && wish.ahead;
    return wish;
  }
  Milliseconds Reaction(int user) {
    return random_.at(static_cast<std::size_t>(user))
        .Between(std::chrono::seconds(2), std::chrono::seconds(25));
  }

 private:
  std::vector<Random> random_;
};

/// What one way of sharing the rigs has given.
struct Tally {
  void Work(int user, WallTime from, WallTime to);
  void Lose(WallTime from, WallTime to);
  WeekFigures Figures(int weeks);

  std::vector<double> waits_min;
  std::map<int, double> got_s;
  double useful_open_s = 0.0;
  double lost_s = 0.0;
  int wishes = 0;
  int served = 0;
};

/// One line for all rigs: whoever has come first gets the first free rig for as long as they work.
/// There is no calendar: who would book comes at that hour and stands in line.
WeekFigures FirstInFirstOut(int weeks, std::uint64_t seed);
/// Each request takes whole slots of half an hour on the first rig that is free at the next slot
/// border, in the order of the requests; a booking takes the first slots at or after its hour. A
/// no-show wastes its slots.
WeekFigures FixedSlots(int weeks, std::uint64_t seed);

}  // namespace faultlab::server::lab::rehearsal
