#include "hardware/lcm/board_lock.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/hardware/remote_world.h"

namespace faultlab::hardware {
namespace {

BenchFile FileOf(BenchFile::Driver driver, const std::string& node = {}) {
  BenchFile file;
  file.driver = driver;
  file.comedi.device = node;
  file.config.description.id = "bench-1";
  return file;
}

TEST(BoardLock, OneProgramHasABoardWhateverItsRigIsCalled) {
  const StateFolder folder;
  const std::string node = folder.path() + "/comedi0";
  std::ofstream(node) << "";
  const BenchFile file = FileOf(BenchFile::Driver::kComedi, node);
  {
    const auto lock = BoardLock::Take(file, "");
    ASSERT_TRUE(lock.ok()) << lock.error().message;
    BenchFile other = file;
    other.config.description.id = "bench-2";
    const auto second = BoardLock::Take(other, "");
    ASSERT_FALSE(second.ok());
    EXPECT_EQ(second.error().code, core::ErrorCode::kConflict);
    EXPECT_NE(second.error().message.find(node), std::string::npos);
  }
  EXPECT_TRUE(BoardLock::Take(file, "").ok()) << "it ends with its holder";
}

TEST(BoardLock, OfABoardWithoutANodeIsBesideTheEpoch) {
  const StateFolder folder;
  const BenchFile file = FileOf(BenchFile::Driver::kNiDaqmx);
  const auto lock = BoardLock::Take(file, folder.path());
  ASSERT_TRUE(lock.ok());
  EXPECT_FALSE(BoardLock::Take(file, folder.path()).ok());
  EXPECT_TRUE(std::filesystem::exists(folder.path() + "/bench-1.lock"));
}

TEST(BoardLock, SimulatorsNeedNoneAndAMissingNodeIsTheDriversToRefuse) {
  const BenchFile simulated = FileOf(BenchFile::Driver::kSimulated);
  const auto one = BoardLock::Take(simulated, "");
  EXPECT_TRUE(BoardLock::Take(simulated, "").ok());
  const BenchFile missing = FileOf(BenchFile::Driver::kComedi, "/nowhere/comedi0");
  EXPECT_TRUE(BoardLock::Take(missing, "").ok());
}

}  // namespace
}  // namespace faultlab::hardware
