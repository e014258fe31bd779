#include "server/plots/canvas.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "server/plots/typeface.h"

namespace faultlab::server {
namespace {

class CanvasTest : public ::testing::Test {
 protected:
  CanvasTest() : type_(Typeface::Load("").value()), canvas_(200, 100, *type_) {}

  /// Darkest channel of a pixel; 255 is white.
  int At(int x, int y) const {
    const std::uint8_t* pixel = canvas_.pixels().data() + 3 * (y * canvas_.width() + x);
    return std::min({pixel[0], pixel[1], pixel[2]});
  }
  int InkIn(int left, int top, int width, int height) const {
    int count = 0;
    for (int y = top; y < top + height; ++y) {
      for (int x = left; x < left + width; ++x) {
        count += At(x, y) < 200 ? 1 : 0;
      }
    }
    return count;
  }

  std::unique_ptr<Typeface> type_;
  Canvas canvas_;
};

TEST_F(CanvasTest, ClipsALineToItsPanel) {
  const PixelPoint line[] = {{-1e9, 50.0}, {1e9, 50.0}};
  canvas_.Polyline(line, {{0, 0, 0}, 2}, {50, 20, 100, 60});
  EXPECT_GT(InkIn(50, 45, 100, 10), 100);
  EXPECT_EQ(InkIn(0, 0, 49, 100), 0);
  EXPECT_EQ(InkIn(151, 0, 49, 100), 0);
}

TEST_F(CanvasTest, LeavesGapsInADashedLine) {
  canvas_.Line({0.0, 50.0}, {200.0, 50.0}, {{0, 0, 0}, 2, Dash::kDashed, 4.0});
  const int dashed = InkIn(0, 45, 200, 10);
  canvas_.Fill({0, 0, 200, 100}, kPaper);
  canvas_.Line({0.0, 50.0}, {200.0, 50.0}, {{0, 0, 0}, 2});
  constexpr double kRoundEnds = 0.9;  // of a solid line: 10 on, 6 off, with caps
  EXPECT_LT(dashed, kRoundEnds * InkIn(0, 45, 200, 10));
  EXPECT_GT(dashed, 0.4 * InkIn(0, 45, 200, 10));
}

TEST_F(CanvasTest, ShadesNothingWhereARectangleHasNoPixels) {
  canvas_.Shade({50, 20, 0, 60}, {0, 0, 0}, 0.5);
  canvas_.Shade({900, 20, 100, 60}, {0, 0, 0}, 0.5);
  EXPECT_EQ(InkIn(0, 0, 200, 100), 0);
}

TEST_F(CanvasTest, DrawsGreekAndMicroAsLettersNotBoxes) {
  const TextBitmap box = type_->Draw("\uFFFF", 40);  // no face contains this letter
  for (const char* letter : {"Ω", "µ", "θ", "σ", "ž", "Ж"}) {
    const TextBitmap drawn = type_->Draw(letter, 40);
    EXPECT_NE(drawn.coverage, box.coverage) << letter;
    EXPECT_GT(drawn.width, 4) << letter;
  }
}

TEST_F(CanvasTest, SetsSubscriptsSmallerAndLower) {
  EXPECT_LT(type_->Width("R_{12}", 40), type_->Width("R12", 40));
  const auto lowest_row = [](const TextBitmap& text) {
    const auto last = std::find_if(
        text.coverage.rbegin(), text.coverage.rend(), [](std::uint8_t c) { return c > 100; });
    return static_cast<int>(text.coverage.rend() - last) / text.width;
  };
  EXPECT_GT(lowest_row(type_->Draw("R_{1}", 40)), lowest_row(type_->Draw("R1", 40)));
}

TEST_F(CanvasTest, AlignsTextAndTurnsIt) {
  canvas_.Text("MMMM", 100.0, 50.0, 16, {0, 0, 0}, Align::kRight);
  EXPECT_EQ(InkIn(101, 0, 99, 100), 0);
  EXPECT_GT(InkIn(40, 40, 60, 20), 50);
  canvas_.Fill({0, 0, 200, 100}, kPaper);
  canvas_.VerticalText("MMMM", 100.0, 50.0, 16, {0, 0, 0});
  EXPECT_GT(InkIn(90, 25, 20, 50), 50);
  EXPECT_EQ(InkIn(0, 0, 85, 100), 0);
  EXPECT_EQ(InkIn(115, 0, 85, 100), 0);
}

TEST_F(CanvasTest, SurvivesBrokenUtf8) {
  EXPECT_GT(type_->Width("\xC3", 20), 0);
  EXPECT_GT(type_->Draw("\xFF\xFE_{", 20).width, 0);
}

TEST(TypefaceTest, NamesThePackageWhenThereIsNoFont) {
  const auto face = Typeface::Load("/nowhere/font.ttf");
  ASSERT_FALSE(face);
  EXPECT_EQ(face.error().code, core::ErrorCode::kUnavailable);
  EXPECT_EQ(face.error().message,
            "no font for pictures: cannot read /nowhere/font.ttf; install the package "
            "fonts-dejavu-core or set FAULTLAB_FONT to a TrueType file");
}

}  // namespace
}  // namespace faultlab::server
