#include "server/plots/mark_labels.h"

#include <gtest/gtest.h>

#include <vector>

namespace faultlab::server {
namespace {

constexpr LabelRoom kRoom{.left = 100, .right = 1000, .gap = 10, .rows_max = 3};
constexpr double kSymbol = 14;

MarkPlace At(double line, double length) {
  return {line, length, kSymbol};
}

void ExpectApart(const std::vector<MarkPlace>& marks, const std::vector<MarkLabel>& labels) {
  const auto end = [&](std::size_t i) {
    const bool whole = labels[i].shown == MarkLabel::Shown::kAll;
    return labels[i].start + (whole ? marks[i].length : marks[i].symbol);
  };
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i].shown == MarkLabel::Shown::kNothing) continue;
    EXPECT_GE(labels[i].start, kRoom.left) << i;
    EXPECT_LE(end(i), kRoom.right) << i;
    EXPECT_TRUE(labels[i].start == marks[i].line ||
                labels[i].start + marks[i].length == marks[i].line)
        << i << " is not at its line";
    for (std::size_t k = 0; k < i; ++k) {
      if (labels[k].shown == MarkLabel::Shown::kNothing || labels[k].row != labels[i].row) continue;
      EXPECT_TRUE(end(k) <= labels[i].start || end(i) <= labels[k].start)
          << k << " and " << i << " overlap";
    }
  }
}

TEST(MarkLabels, AFaultAndItsDetectionAreBesideTheirLineInOneRow) {
  const std::vector<MarkPlace> marks = {At(400, 120), At(400, 150)};
  const auto labels = PlaceMarkLabels(marks, kRoom);
  EXPECT_TRUE(labels[0].on_left);
  EXPECT_FALSE(labels[1].on_left);
  EXPECT_EQ(RowsOf(labels), 1);
  ExpectApart(marks, labels);
}

TEST(MarkLabels, ALabelThatWouldLeaveThePictureGoesToTheOtherSideOrToAnotherRow) {
  const std::vector<MarkPlace> marks = {
      At(500, 120), At(500, 220), At(700, 120), At(700, 220), At(850, 150), At(850, 220)};
  const auto labels = PlaceMarkLabels(marks, kRoom);
  for (const MarkLabel& label : labels) EXPECT_EQ(label.shown, MarkLabel::Shown::kAll);
  EXPECT_GT(RowsOf(labels), 1);
  ExpectApart(marks, labels);
}

TEST(MarkLabels, WithoutRoomForTextsThereAreSymbolsAndThenNothing) {
  std::vector<MarkPlace> marks;
  for (int i = 0; i < 20; ++i) marks.push_back(At(500 + 4 * i, 250));
  const auto labels = PlaceMarkLabels(marks, kRoom);
  EXPECT_EQ(RowsOf(labels), kRoom.rows_max);
  EXPECT_EQ(labels.back().shown, MarkLabel::Shown::kNothing);
  ExpectApart(marks, labels);
}

TEST(MarkLabels, ATextLongerThanThePictureIsASymbol) {
  const std::vector<MarkPlace> marks = {At(500, 2000)};
  const auto labels = PlaceMarkLabels(marks, kRoom);
  EXPECT_EQ(labels[0].shown, MarkLabel::Shown::kSymbol);
  EXPECT_EQ(labels[0].start, 500);
}

}  // namespace
}  // namespace faultlab::server
