// The names on the bus: those with a key here, and those that nothing proves.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "hardware/lcm/key_ring.h"
#include "hardware/lcm/unproven_rigs.h"
#include "tests/hardware/remote_world.h"

namespace faultlab::hardware {
namespace {

using std::chrono::seconds;

TEST(UnprovenRigs, AreBoundedAndTheLongestUnheardLeavesFirst) {
  UnprovenRigs names;
  names.Hear("true-1", RigRefusal::kNoKey, seconds(0));
  for (int i = 0; i < 63; ++i)
    names.Hear("invented-" + std::to_string(i), RigRefusal::kOtherKey, seconds(1));
  names.Hear("true-1", RigRefusal::kNoKey, seconds(2));
  for (int i = 63; i < 10'500; ++i) {
    names.Hear("invented-" + std::to_string(i), RigRefusal::kOtherKey, seconds(3));
    ASSERT_LE(names.List(seconds(3)).size(), UnprovenRigs::kNamesMax);
  }
  names.Hear("true-1", RigRefusal::kNoKey, seconds(4));
  const auto list = names.List(seconds(4));
  EXPECT_EQ(list.size(), UnprovenRigs::kNamesMax);
  EXPECT_EQ(std::count_if(list.begin(),
                          list.end(),
                          [](const auto& each) {
                            return each.name == "true-1" && each.why == RigRefusal::kNoKey;
                          }),
            1)
      << "no flood shuts a name out";
}

TEST(UnprovenRigs, LeaveAfterAMinuteOfSilence) {
  UnprovenRigs names;
  names.Hear("one", RigRefusal::kOtherKey, seconds(0));
  names.Hear("two", RigRefusal::kOtherKey, seconds(30));
  EXPECT_EQ(names.List(seconds(59)).size(), 2u);
  EXPECT_EQ(names.List(seconds(60)).size(), 1u);
  EXPECT_TRUE(names.List(seconds(90)).empty());
}

TEST(KeyRing, FindsAKeyThatWasCopiedLaterAndOneThatWasReplaced) {
  const StateFolder folder;
  KeyRing keys(folder.path());
  EXPECT_EQ(keys.Find("far-1", seconds(0)), std::nullopt);
  const RigKey first = LoadOrMakeRigKey(folder.path(), "far-1").value();
  EXPECT_EQ(keys.Find("far-1", seconds(1)), std::nullopt) << "the disk is looked at every 2 s";
  EXPECT_EQ(keys.Find("far-1", seconds(2)), first);
  std::filesystem::remove(folder.path() + "/far-1.key");
  const RigKey second = LoadOrMakeRigKey(folder.path(), "far-1").value();
  EXPECT_EQ(keys.Find("far-1", seconds(4)), second);
}

TEST(KeyRing, LeavesOutWhatIsNoKey) {
  const StateFolder folder;
  std::ofstream(folder.path() + "/half.key") << "0123";
  std::ofstream(folder.path() + "/other.txt") << std::string(64, 'a');
  std::filesystem::create_directory(folder.path() + "/folder.key");
  KeyRing keys(folder.path());
  for (const char* name : {"half", "other", "folder"}) {
    EXPECT_EQ(keys.Find(name, seconds(0)), std::nullopt) << name;
  }
  KeyRing nowhere(folder.path() + "/none");
  EXPECT_EQ(nowhere.Find("half", seconds(0)), std::nullopt);
}

}  // namespace
}  // namespace faultlab::hardware
