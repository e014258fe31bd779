#include "server/run/tallied_rig.h"

#include <gmock/gmock.h>

#include "tests/paper_rig.h"
#include "tests/server/run/fake_rig.h"

namespace faultlab::server {
namespace {

using hardware::RigEvent;
using hardware::RigEventKind;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;
using testing::SizeIs;

class TalliedRigTest : public testing::Test {
 protected:
  void Confirm(core::Component component, double value) {
    RigEvent event;
    event.kind = RigEventKind::kRelayConfirmed;
    event.component = component;
    event.value = value;
    fake_->Say(event);
  }
  void ReadAll() {
    std::vector<hardware::RigMessage> out;
    (void)rig_.Read(out, std::chrono::milliseconds(0));
  }

  std::shared_ptr<tests::FakeRig> fake_ = std::make_shared<tests::FakeRig>("bench-1");
  std::shared_ptr<RigTally> tally_ = std::make_shared<RigTally>();
  TalliedRig rig_{fake_, tally_};
};

TEST_F(TalliedRigTest, CountsAClosingOfEachPositionAndTheReturnToNominal) {
  Confirm(paper::kR1, 56.0);   // Do1
  Confirm(paper::kR1, 56.0);   // nothing moves
  Confirm(paper::kR9, 33e3);   // Do18
  Confirm(paper::kR1, 100.0);  // Do0
  ReadAll();
  rig_.SafeStop("the end");  // R1 to Do17, R9 to Do19
  rig_.SafeStop("again");
  EXPECT_THAT(tally_->Take().closings.at("bench-1"),
              ElementsAre(Pair(0, 1), Pair(1, 1), Pair(17, 1), Pair(18, 1), Pair(19, 1)));
  EXPECT_THAT(tally_->Take().closings, IsEmpty()) << "it was taken";
}

TEST_F(TalliedRigTest, TellsOfTripsAndOfAStrayingDelta) {
  RigEvent trip;
  trip.kind = RigEventKind::kTrip;
  trip.text = "stall";
  fake_->Say(trip);
  RigEvent strays;
  strays.kind = RigEventKind::kDeltaStrays;
  strays.text = "9.9 ms";
  fake_->Say(strays);
  ReadAll();
  ReadAll();
  const RigTally::Taken taken = tally_->Take();
  ASSERT_THAT(taken.news, SizeIs(2));
  EXPECT_EQ(taken.news[0].event, RigTally::Event::kTrip);
  EXPECT_EQ(taken.news[0].rig, "bench-1");
  EXPECT_EQ(taken.news[0].text, "stall");
  EXPECT_EQ(taken.news[1].event, RigTally::Event::kDeltaStrays);
}

}  // namespace
}  // namespace faultlab::server
