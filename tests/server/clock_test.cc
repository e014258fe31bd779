#include "server/clock.h"

#include <gtest/gtest.h>

#include <optional>
#include <semaphore>

#include "server/repeated.h"

namespace faultlab::server {
namespace {

using std::chrono::hours;

TEST(Repeated, TakesATurnEachTimeThatItsClockHasPassedAPause) {
  ManualClock clock;
  std::counting_semaphore<> turns{0};
  std::optional<Repeated> looks;
  looks.emplace(clock, Repeated::First::kAtOnce, hours(24), [&] { turns.release(); });
  turns.acquire();
  for (int day = 0; day < 3; ++day) {
    clock.Advance(hours(22));
    EXPECT_FALSE(turns.try_acquire());
    // Its pause begins when its turn has ended, perhaps a step later.
    while (!turns.try_acquire()) clock.Advance(hours(1));
  }
  looks.reset();  // in mid-pause
  EXPECT_FALSE(turns.try_acquire());
}

TEST(Repeated, MayBeginWithAPause) {
  ManualClock clock;
  std::counting_semaphore<> turn{0};
  const Repeated looks(clock, Repeated::First::kAfterAPause, hours(1), [&] { turn.release(); });
  EXPECT_FALSE(turn.try_acquire());
  while (!turn.try_acquire()) clock.Advance(hours(1));
}

}  // namespace
}  // namespace faultlab::server
