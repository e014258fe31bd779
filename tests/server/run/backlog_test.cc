#include "server/run/backlog.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/temp_folder.h"

namespace faultlab::server {
namespace {

namespace fs = std::filesystem;

class BacklogTest : public ::testing::Test {
 protected:
  static Backlog::Part Samples(std::int64_t first, std::size_t count) {
    Backlog::Part part;
    for (std::size_t i = 0; i < count; ++i) {
      core::Sample sample;
      sample.index = first + static_cast<std::int64_t>(i);
      sample.um_v = 0.1 * static_cast<double>(sample.index);
      part.samples.push_back(sample);
    }
    return part;
  }
  std::string folder() const { return folder_.File("backlog"); }
  std::string path() const { return folder() + "/run-a.backlog"; }
  Backlog Opened() const { return Backlog::Open(folder(), "run-a").value(); }

  tests::TempFolder folder_;
};

TEST_F(BacklogTest, GivesBackItsPartsInOrderAlsoToAnotherProcess) {
  {
    Backlog backlog = Opened();
    EXPECT_TRUE(backlog.empty());
    ASSERT_TRUE(backlog.Append(Samples(0, 100)).ok());
    ASSERT_TRUE(
        backlog.Append({.events = {{7, "detected", R"({"kind":"detected"})"}}, .events_before = 3})
            .ok());
    ASSERT_TRUE(
        backlog.Append({.end = RunEnd{RunState::kStopped, FromMilliseconds(1'700'000)}}).ok());
  }
  EXPECT_EQ(Backlog::RunsIn(folder()), std::vector<std::string>{"run-a"});
  Backlog backlog = Opened();
  auto part = backlog.Front();
  ASSERT_TRUE(part);
  ASSERT_EQ(part->samples.size(), 100u);
  EXPECT_EQ(part->samples.back().um_v, 0.1 * 99);
  backlog.Pop();
  part = backlog.Front();
  ASSERT_TRUE(part);
  ASSERT_EQ(part->events.size(), 1u);
  EXPECT_EQ(part->events[0].index, 7);
  EXPECT_EQ(part->events[0].json, R"({"kind":"detected"})");
  EXPECT_EQ(part->events_before, 3);
  backlog.Pop();
  part = backlog.Front();
  ASSERT_TRUE(part && part->end);
  EXPECT_EQ(part->end->state, RunState::kStopped);
  EXPECT_EQ(ToMilliseconds(part->end->at), 1'700'000);
  backlog.Pop();
  EXPECT_TRUE(backlog.empty());
  EXPECT_FALSE(backlog.Front());
  backlog.Remove();
  EXPECT_TRUE(Backlog::RunsIn(folder()).empty());
}

TEST_F(BacklogTest, OfATornFileTheWholePartsRemain) {
  {
    Backlog backlog = Opened();
    ASSERT_TRUE(backlog.Append(Samples(0, 100)).ok());
    ASSERT_TRUE(backlog.Append(Samples(100, 100)).ok());
  }
  fs::resize_file(path(), fs::file_size(path()) - 1);
  Backlog backlog = Opened();
  ASSERT_TRUE(backlog.Front());
  EXPECT_EQ(backlog.Front()->samples.front().index, 0);
  backlog.Pop();
  EXPECT_FALSE(backlog.Front());
}

TEST_F(BacklogTest, ADamagedPartIsNotRead) {
  {
    Backlog backlog = Opened();
    ASSERT_TRUE(
        backlog.Append({.end = RunEnd{RunState::kStopped, FromMilliseconds(1'700'000)}}).ok());
  }
  std::fstream file(path(), std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(-3, std::ios::end);
  file.put('9');
  file.close();
  EXPECT_FALSE(Opened().Front());
}

TEST_F(BacklogTest, RefusesAForeignFileAndLeavesItAlone) {
  fs::create_directories(folder());
  std::ofstream(path()) << "something else";
  EXPECT_FALSE(Backlog::Open(folder(), "run-a").ok());
  EXPECT_EQ(fs::file_size(path()), 14u);
}

TEST_F(BacklogTest, IsBounded) {
  { ASSERT_TRUE(Opened().Append(Samples(0, 100)).ok()); }
  fs::resize_file(path(), Backlog::kBytesMax - 100);
  Backlog backlog = Opened();
  EXPECT_FALSE(backlog.Append(Samples(100, 100)).ok());
  EXPECT_EQ(static_cast<std::int64_t>(fs::file_size(path())), Backlog::kBytesMax - 100);
  EXPECT_TRUE(backlog.Append({.end = RunEnd{}}).ok()) << "the end has room";
}

}  // namespace
}  // namespace faultlab::server
