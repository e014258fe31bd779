#include "server/lab/timeline.h"

#include "tests/server/lab/lab_fixture.h"

namespace faultlab::server::lab {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class Timeline : public LabFixture {
 protected:
  std::vector<int> FreeCounts(Milliseconds step, Milliseconds length) {
    std::vector<int> counts;
    for (const Slot& slot :
         Availability(lab_.state(), "bench", {now_, now_ + length}, step, now_, lab_.policy())) {
      counts.push_back(slot.free);
    }
    return counts;
  }
};

TEST_F(Timeline, CountsTheRigsThatAreFreeForAWholeSlot) {
  AddReadyRigs(2);
  Book(kAnn, minutes(60), minutes(30));
  ASSERT_TRUE(
      lab_.AddOutage("bench-2", {now_ + minutes(90), now_ + minutes(120)}, "works", now_).ok());
  EXPECT_THAT(FreeCounts(minutes(30), minutes(150)), ElementsAre(2, 2, 1, 0, 2))
      << "in the fourth slot one rig is checked, the other is out";
}

TEST_F(Timeline, OffersNothingOnDeadRigsAndNothingInThePast) {
  AddReadyRigs(1);
  const auto slots = Availability(
      lab_.state(), "bench", {now_ - hours(1), now_ + hours(1)}, minutes(30), now_, lab_.policy());
  ASSERT_EQ(slots.size(), 4u);
  EXPECT_EQ(slots[1].free, 0);
  EXPECT_EQ(slots[2].free, 1);
  ASSERT_TRUE(lab_.Quarantine("bench-1", "", now_).ok());
  EXPECT_THAT(FreeCounts(minutes(30), minutes(60)), ElementsAre(0, 0));
}

TEST_F(Timeline, NextFreeStartsRightBehindTheCheckOfWhatEnds) {
  AddReadyRigs(1);
  const Booking booking = Book(kAnn, Milliseconds{0}, minutes(30));
  const auto starts =
      NextFree(lab_.state(), "bench", {now_, now_ + hours(3)}, minutes(30), 2, now_, lab_.policy());
  const WallTime first = booking.during.end + lab_.policy().cleaning;
  EXPECT_THAT(starts, ElementsAre(first, first + minutes(5)));
}

TEST_F(Timeline, EveryNextFreeStartCanReallyBeBooked) {
  AddReadyRigs(2);
  Book(kAnn, minutes(10), minutes(50));
  Book(kBob, minutes(30), minutes(70));
  const auto starts = NextFree(
      lab_.state(), "bench", {now_, now_ + hours(5)}, minutes(25), 12, now_, lab_.policy());
  ASSERT_EQ(starts.size(), 12u);
  for (const WallTime start : starts) {
    Scheduler copy = lab_;
    EXPECT_TRUE(copy.Book(kCem, "bench", {start, start + minutes(25)}, now_).ok());
  }
}

TEST_F(Timeline, BoundsHowMuchItAnswers) {
  AddReadyRigs(1);
  const auto slots = Availability(
      lab_.state(), "bench", {now_, now_ + hours(24 * 3650)}, minutes(1), now_, lab_.policy());
  EXPECT_EQ(slots.size(), 2000u);
  EXPECT_THAT(
      NextFree(
          lab_.state(), "nothing", {now_, now_ + hours(5)}, minutes(25), 3, now_, lab_.policy()),
      IsEmpty());
}

}  // namespace
}  // namespace faultlab::server::lab
