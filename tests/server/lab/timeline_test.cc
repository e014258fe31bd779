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
    for (const Slot& slot : Availability(
             lab_.state(), "bench", {now_, now_ + length}, step, step, now_, lab_.policy())) {
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
  EXPECT_THAT(FreeCounts(minutes(30), minutes(150)), ElementsAre(2, 2, 1, 1, 2))
      << "each slot has its check in itself; in the third one rig is booked, in the fourth one out";
}

TEST_F(Timeline, OffersNothingOnDeadRigsAndNothingInThePast) {
  AddReadyRigs(1);
  const auto slots = Availability(lab_.state(),
                                  "bench",
                                  {now_ - hours(1), now_ + hours(1)},
                                  minutes(30),
                                  minutes(30),
                                  now_,
                                  lab_.policy());
  ASSERT_EQ(slots.size(), 4u);
  EXPECT_EQ(slots[1].free, 0);
  EXPECT_EQ(slots[2].free, 1);
  ASSERT_TRUE(lab_.Quarantine("bench-1", "", now_).ok());
  EXPECT_THAT(FreeCounts(minutes(30), minutes(60)), ElementsAre(0, 0));
}

TEST_F(Timeline, WhatIsFreeCanBeBookedWhateverTheLength) {
  AddReadyRigs(2);
  Book(kAnn, minutes(60), minutes(30));
  Book(kBob, minutes(95), minutes(40));
  Book(kBob, minutes(200), minutes(30));
  ASSERT_TRUE(
      lab_.AddOutage("bench-2", {now_ + minutes(150), now_ + minutes(180)}, "works", now_).ok());
  for (const Milliseconds length : {minutes(15), minutes(30), minutes(60), minutes(90)}) {
    int free = 0;
    for (const Slot& slot : Availability(lab_.state(),
                                         "bench",
                                         {now_, now_ + hours(6)},
                                         minutes(5),
                                         length,
                                         now_,
                                         lab_.policy())) {
      if (slot.free == 0) continue;
      ++free;
      Scheduler copy = lab_;
      const auto booked = copy.Book(kCem, "bench", slot.during, now_);
      EXPECT_TRUE(booked.ok()) << length.count() << " at " << (slot.during.start - now_).count();
    }
    EXPECT_GT(free, 10);
  }
}

TEST_F(Timeline, NextFreeStartsWhereABookingEndsWithItsCheck) {
  AddReadyRigs(1);
  const Booking booking = Book(kAnn, Milliseconds{0}, minutes(30));
  const auto starts =
      NextFree(lab_.state(), "bench", {now_, now_ + hours(8)}, minutes(30), 4, now_, lab_.policy());
  const WallTime first = booking.during.end;
  EXPECT_THAT(starts,
              ElementsAre(first, first + minutes(30), first + minutes(90), first + minutes(210)))
      << "on the grid of five minutes, further and further apart";
}

TEST_F(Timeline, EveryNextFreeStartCanReallyBeBooked) {
  AddReadyRigs(2);
  Book(kAnn, minutes(10), minutes(50));
  Book(kBob, minutes(30), minutes(70));
  const auto starts = NextFree(
      lab_.state(), "bench", {now_, now_ + hours(24 * 7)}, minutes(25), 8, now_, lab_.policy());
  ASSERT_EQ(starts.size(), 8u);
  EXPECT_GT(starts.back() - starts.front(), hours(48));
  for (const WallTime start : starts) {
    Scheduler copy = lab_;
    EXPECT_TRUE(copy.Book(kCem, "bench", {start, start + minutes(25)}, now_).ok());
  }
}

TEST_F(Timeline, EverySlotShownAsFreeCanReallyBeBooked) {
  AddReadyRigs(2);
  Book(kAnn, minutes(10), minutes(50));
  Book(kBob, minutes(30), minutes(70));
  const auto slots = Availability(lab_.state(),
                                  "bench",
                                  {now_, now_ + hours(5)},
                                  minutes(10),
                                  minutes(10),
                                  now_,
                                  lab_.policy());
  int free = 0;
  for (const Slot& slot : slots) {
    Scheduler copy = lab_;
    EXPECT_EQ(copy.Book(kCem, "bench", slot.during, now_).ok(), slot.free > 0);
    free += slot.free > 0 ? 1 : 0;
  }
  EXPECT_GT(free, 5);
}

TEST_F(Timeline, BoundsHowMuchItAnswers) {
  AddReadyRigs(1);
  const auto slots = Availability(lab_.state(),
                                  "bench",
                                  {now_, now_ + hours(24 * 3650)},
                                  minutes(1),
                                  minutes(1),
                                  now_,
                                  lab_.policy());
  EXPECT_EQ(slots.size(), 2000u);
  EXPECT_THAT(
      NextFree(
          lab_.state(), "nothing", {now_, now_ + hours(5)}, minutes(25), 3, now_, lab_.policy()),
      IsEmpty());
}

}  // namespace
}  // namespace faultlab::server::lab
