// A run in pieces: late, repeated, in any order, with gaps.
#include "hardware/lcm/reorder_buffer.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/signals/random.h"
#include "hardware/lcm/clock_offset.h"
#include "hardware/lcm/retransmit_buffer.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {
namespace {

constexpr std::int64_t kRun = 7;

core::Sample SampleOf(std::int64_t index) {
  return {.index = index, .t_s = static_cast<double>(index) * 0.01};
}

faultlab_msgs::rig_stream_t Piece(const RetransmitBuffer& ring,
                                  std::int64_t from,
                                  std::int64_t to) {
  faultlab_msgs::rig_stream_t piece = ring.Pieces(from, to).front();
  piece.run = kRun;
  return piece;
}

std::vector<std::int64_t> Indices(const std::vector<RigMessage>& messages) {
  std::vector<std::int64_t> indices;
  for (const RigMessage& message : messages) {
    if (const auto* sample = std::get_if<core::Sample>(&message)) indices.push_back(sample->index);
  }
  return indices;
}

TEST(ReorderBuffer, GivesEveryMessageOnceAndInOrderWhateverTheOrderOfThePieces) {
  constexpr std::int64_t kSamples = 200;
  RetransmitBuffer ring(1000);
  for (std::int64_t k = 0; k < kSamples; ++k) ring.Push(SampleOf(k));
  std::vector<faultlab_msgs::rig_stream_t> pieces;
  for (std::int64_t from = 0; from < kSamples; from += 5) {
    for (int copy = 0; copy < 2; ++copy) pieces.push_back(Piece(ring, from, from + 5));
  }
  core::Random random(3);
  for (std::size_t i = pieces.size(); i > 1; --i) {
    std::swap(pieces[i - 1],
              pieces[static_cast<std::size_t>(random.Uniform() * static_cast<double>(i))]);
  }
  ReorderBuffer assembly;
  assembly.Begin(kRun, paper::Bench());
  std::vector<RigMessage> out;
  for (const auto& piece : pieces) assembly.Take(piece, out);
  const std::vector<std::int64_t> indices = Indices(out);
  ASSERT_EQ(indices.size(), static_cast<std::size_t>(kSamples));
  EXPECT_TRUE(std::is_sorted(indices.begin(), indices.end()));
  EXPECT_TRUE(assembly.whole());
  EXPECT_EQ(assembly.next_index(), kSamples);
}

TEST(ReorderBuffer, NamesItsHolesAndIsWholeWhenTheyAreFilled) {
  RetransmitBuffer ring(1000);
  for (std::int64_t k = 0; k < 40; ++k) ring.Push(SampleOf(k));
  ReorderBuffer assembly;
  assembly.Begin(kRun, paper::Bench());
  std::vector<RigMessage> out;
  assembly.Take(Piece(ring, 0, 4), out);
  assembly.Take(Piece(ring, 8, 12), out);
  assembly.Expect(20);
  EXPECT_EQ(Indices(out).size(), 4u);
  const auto holes = assembly.Holes(10);
  ASSERT_EQ(holes.size(), 2u);
  EXPECT_EQ(holes[0].from, 4);
  EXPECT_EQ(holes[0].to, 8);
  EXPECT_EQ(holes[1].from, 12);
  EXPECT_EQ(holes[1].to, 20);
  for (const auto& hole : holes) assembly.Take(Piece(ring, hole.from, hole.to), out);
  EXPECT_TRUE(assembly.whole());
  EXPECT_EQ(Indices(out).size(), 20u);
  EXPECT_EQ(assembly.refilled(), 12);
}

TEST(ReorderBuffer, SaysWhatTheAgentNoLongerHasAndKeepsWhatItHas) {
  RetransmitBuffer ring(10);
  ReorderBuffer assembly;
  assembly.Begin(kRun, paper::Bench());
  std::vector<RigMessage> out;
  for (std::int64_t k = 0; k < 6; ++k) ring.Push(SampleOf(k));
  assembly.Take(Piece(ring, 0, 2), out);
  assembly.Take(Piece(ring, 4, 6), out);
  for (std::int64_t k = 6; k < 30; ++k) ring.Push(SampleOf(k));
  assembly.Take(Piece(ring, 25, 30), out);
  std::vector<double> gaps;
  for (const RigMessage& message : out) {
    const auto* event = std::get_if<RigEvent>(&message);
    if (event != nullptr && event->kind == RigEventKind::kGap) gaps.push_back(event->value);
  }
  EXPECT_EQ(gaps, (std::vector<double>{2.0, 14.0}));
  EXPECT_EQ(Indices(out), (std::vector<std::int64_t>{0, 1, 4, 5}));
  EXPECT_EQ(assembly.Holes(10).front().from, 20);
}

TEST(ReorderBuffer, TakesNothingOfAnotherRun) {
  RetransmitBuffer ring(10);
  ring.Push(SampleOf(0));
  ReorderBuffer assembly;
  assembly.Begin(kRun + 1, paper::Bench());
  std::vector<RigMessage> out;
  assembly.Take(Piece(ring, 0, 1), out);
  EXPECT_TRUE(out.empty());
  EXPECT_TRUE(assembly.whole());
}

TEST(ClockOffset, IsTheOneOfTheQuickestExchange) {
  ClockOffset offset;
  EXPECT_FALSE(offset.offset_s().has_value());
  constexpr std::int64_t kMs = 1'000'000;
  constexpr std::int64_t kAhead = 250 * kMs;  // the agent's clock
  // 10 ms there, 30 ms back: 10 ms off.
  offset.Exchange(0, 10 * kMs + kAhead, 12 * kMs + kAhead, 42 * kMs);
  EXPECT_NEAR(*offset.offset_s(), 0.240, 1e-9);
  EXPECT_NEAR(offset.round_trip_s(), 0.040, 1e-9);
  offset.Exchange(100 * kMs, 101 * kMs + kAhead, 101 * kMs + kAhead, 102 * kMs);
  EXPECT_NEAR(*offset.offset_s(), 0.250, 1e-9);
  offset.Exchange(200 * kMs, 260 * kMs + kAhead, 260 * kMs + kAhead, 270 * kMs);
  EXPECT_NEAR(*offset.offset_s(), 0.250, 1e-9) << "a slow exchange tells nothing new";
}

}  // namespace
}  // namespace faultlab::hardware
