#include "server/run/rig_bay.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/server/run/fake_rig.h"

namespace faultlab::server {
namespace {

using tests::FakeRig;

hardware::RigDescription Simulated(const std::string& id) {
  hardware::RigDescription description;
  description.id = id;
  description.kind = hardware::RigKind::kSimulated;
  return description;
}

class RigBayTest : public ::testing::Test {
 protected:
  RigBayTest() {
    for (const char* id : {"sim-1", "sim-2"}) {
      bay_.Add(Simulated(id), "bench", hardware::Epoch{10}, [this, id] {
        last_ = std::make_shared<FakeRig>(id);
        return last_;
      });
    }
  }
  RigBay bay_;
  std::shared_ptr<FakeRig> last_;
};

TEST_F(RigBayTest, LeasesAnyFreeSimulatedRigUntilNoneIsLeft) {
  auto a = bay_.Acquire("");
  auto b = bay_.Acquire("");
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_NE(a.value().rig().description().id, b.value().rig().description().id);
  const auto none = bay_.Acquire("");
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, core::ErrorCode::kBusy);
  a.value().Release();
  EXPECT_TRUE(bay_.Acquire("").ok());
}

TEST_F(RigBayTest, RaisesTheEpochWithEachLease) {
  const auto first = bay_.Acquire("sim-1").value().epoch();
  const auto second = bay_.Acquire("sim-1").value().epoch();
  EXPECT_EQ(first, hardware::Epoch{11});
  EXPECT_EQ(second, hardware::Epoch{12});
}

TEST_F(RigBayTest, StopsTheRigWhenALeaseEnds) {
  { auto lease = bay_.Acquire("sim-2"); }
  ASSERT_EQ(last_->stops().size(), 1u);
  EXPECT_FALSE(bay_.List()[1].leased);
}

TEST_F(RigBayTest, NamesAnUnknownRig) {
  const auto unknown = bay_.Acquire("sim-9");
  ASSERT_FALSE(unknown.ok());
  EXPECT_EQ(unknown.error().code, core::ErrorCode::kNotFound);
  EXPECT_NE(unknown.error().message.find("sim-9"), std::string::npos);
}

TEST_F(RigBayTest, StaysFreeWhenARigCannotBeBuilt) {
  RigBay bay;
  bool fail = true;
  bay.Add(Simulated("sim-1"), "bench", hardware::Epoch{0}, [&]() -> std::shared_ptr<FakeRig> {
    if (fail) throw std::runtime_error("no device");
    return std::make_shared<FakeRig>("sim-1");
  });
  EXPECT_THROW(static_cast<void>(bay.Acquire("sim-1")), std::runtime_error);
  fail = false;
  EXPECT_TRUE(bay.Acquire("sim-1").ok());
}

}  // namespace
}  // namespace faultlab::server
