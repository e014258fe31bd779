#include "server/lab/obstacles.h"

#include "tests/server/lab/lab_fixture.h"

namespace faultlab::server::lab {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class Obstacles : public LabFixture {
 protected:
  std::vector<Obstacle> Now() const {
    Ticket ticket;
    ticket.rig_class = "bench";
    ticket.min = minutes(10);
    return ObstaclesOf(lab_.state(), ticket, now_);
  }
};

TEST_F(Obstacles, NamesTheBookingForWhichAFreeRigIsKept) {
  AddReadyRigs(1);
  EXPECT_THAT(Now(), IsEmpty());
  const Booking later = Book(kBob, hours(3), minutes(60));
  const Booking booking = Book(kAnn, minutes(7), minutes(60));
  const Ticket ticket = Ask(kCem, minutes(10));
  EXPECT_EQ(ticket.place, 1);
  ASSERT_EQ(Status("bench-1"), RigStatus::kReady);
  EXPECT_THAT(Now(), ElementsAre(Obstacle{"bench-1", ObstacleKind::kBooking, booking.during}));
  EXPECT_GE(*ticket.expected, booking.during.end);
  EXPECT_LT(*ticket.expected, later.during.start);
}

TEST_F(Obstacles, NamesWhatIsOnARigBeforeWhatComes) {
  AddReadyRigs(2);
  Book(kBob, hours(2), minutes(30));
  const Session session = Start(kAnn, minutes(30));
  ASSERT_EQ(session.rig, "bench-1");
  ASSERT_TRUE(
      lab_.AddOutage("bench-2", {now_ + minutes(5), now_ + minutes(60)}, "works", now_).ok());
  EXPECT_THAT(
      Now(),
      ElementsAre(
          Obstacle{"bench-1", ObstacleKind::kSession, {now_, session.hard_end}},
          Obstacle{"bench-2", ObstacleKind::kOutage, {now_ + minutes(5), now_ + minutes(60)}}));
  ASSERT_TRUE(lab_.EndSession(session.id, EndReason::kEnded, "", now_).ok());
  EXPECT_EQ(Now().front().kind, ObstacleKind::kCheck);
  ASSERT_TRUE(lab_.Quarantine("bench-1", "hot", now_).ok());
  EXPECT_EQ(Now().size(), 1u) << "nobody waits for a rig that is out";
}

}  // namespace
}  // namespace faultlab::server::lab
