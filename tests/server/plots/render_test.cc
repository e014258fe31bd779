#include "server/plots/render.h"

#include <gtest/gtest.h>

#include <boost/json/serialize.hpp>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "server/plots/figure_json.h"

namespace faultlab::server {
namespace {

/// Two panels, a gap in the line, everything that can be drawn once.
Figure SmallFigure() {
  Figure figure;
  figure.title = "Title with θ and Ω";
  figure.subtitle = "R_{1} = 100 Ω";
  figure.x = {"Time t", "s", std::nullopt};
  for (int p = 0; p < 2; ++p) {
    Panel panel;
    panel.y = {"U_{m}", "V", std::nullopt};
    Series series;
    series.name = "measured";
    for (int k = 0; k < 200; ++k) {
      series.x.push_back(0.01 * k);
      series.y.push_back(k == 100 ? std::numeric_limits<double>::quiet_NaN() : std::sin(0.1 * k));
    }
    panel.series.push_back(series);
    panel.levels.push_back({0.25, "nominal", Ink::kGrey});
    panel.bands.push_back({0.5, 0.7, std::nullopt, std::nullopt, "settling", Ink::kGrey});
    figure.panels.push_back(panel);
  }
  figure.marks = {{MarkKind::kFault, 0.5, "fault"}, {MarkKind::kDetected, 0.52, "detected"}};
  figure.footer = "rig sim-1";
  return figure;
}

cv::Mat Decode(const std::string& png) {
  const std::vector<std::uint8_t> bytes(png.begin(), png.end());
  return cv::imdecode(bytes, cv::IMREAD_COLOR);
}

int InkOf(const cv::Mat& image, cv::Vec3b bgr) {
  int count = 0;
  for (const cv::Vec3b& pixel : cv::Mat_<cv::Vec3b>(image)) {
    count += pixel == bgr ? 1 : 0;
  }
  return count;
}

TEST(Render, MakesAPngThatAnotherDecoderReads) {
  const core::Result<std::string> png = RenderPng(SmallFigure());
  ASSERT_TRUE(png) << png.error().message;
  const cv::Mat image = Decode(png.value());
  ASSERT_EQ(image.cols, 1600);
  ASSERT_EQ(image.rows, 900);
  EXPECT_EQ(image.at<cv::Vec3b>(0, 0), cv::Vec3b(255, 255, 255)) << "white ground";
  EXPECT_GT(InkOf(image, cv::Vec3b(0xB2, 0x72, 0x00)), 500) << "the blue line";
  EXPECT_GT(InkOf(image, cv::Vec3b(0x1B, 0x00, 0xB3)), 500) << "the red line of the fault";
}

TEST(Render, DoublesThePixelsAndKeepsTheLayout) {
  RenderOptions options;
  const cv::Mat once = Decode(RenderPng(SmallFigure(), options).value());
  options.scale = 2;
  const cv::Mat twice = Decode(RenderPng(SmallFigure(), options).value());
  ASSERT_EQ(twice.cols, 3200);
  ASSERT_EQ(twice.rows, 1800);
  cv::Mat shrunk;
  cv::resize(twice, shrunk, once.size(), 0, 0, cv::INTER_AREA);
  cv::Mat difference;
  cv::absdiff(shrunk, once, difference);
  constexpr double kEdgesOnly = 12.0;  // grey levels: lines and letters fall on other pixels
  EXPECT_LT(cv::norm(difference, cv::NORM_L1) / static_cast<double>(difference.total() * 3),
            kEdgesOnly);
}

TEST(Render, DrawsFiguresWithNothingInThem) {
  EXPECT_TRUE(RenderPng(Figure{}));
  Figure figure = SmallFigure();
  for (Panel& panel : figure.panels) {
    panel.series.clear();
    panel.levels.clear();
  }
  EXPECT_TRUE(RenderPng(figure));
  figure = SmallFigure();
  for (double& value : figure.panels[0].series[0].y) {
    value = std::numeric_limits<double>::quiet_NaN();
  }
  for (double& value : figure.panels[1].series[0].y) {
    value = 3.0;
  }
  EXPECT_TRUE(RenderPng(figure));
  figure.panels[1].series[0].y[3] = 1e300;
  figure.panels[1].series[0].y[4] = -1e300;
  EXPECT_TRUE(RenderPng(figure)) << "a wild value is drawn outside the paper, not into memory";
}

TEST(Render, RefusesSizesOutOfRangeByName) {
  RenderOptions options;
  options.scale = 3;
  EXPECT_EQ(RenderPng(SmallFigure(), options).error().field, "scale");
  options = {};
  options.width_px = 100'000;
  EXPECT_EQ(RenderPng(SmallFigure(), options).error().field, "width");
  options = {};
  options.height_px = 10;
  EXPECT_EQ(RenderPng(SmallFigure(), options).error().field, "height");
}

TEST(Render, DrawsAMatrixOfCells) {
  Figure figure;
  figure.title = "Isolability";
  figure.matrix.rows = {"R_{1}", "R_{9}"};
  figure.matrix.columns = {"R_{1}", "R_{9}", "J"};
  figure.matrix.value = {0, 0.5, 1, 0.25, 0, std::nan("")};
  figure.matrix.text = {"", "0.5", "1", "0.25", "", ""};
  const core::Result<std::string> png = RenderPng(figure);
  ASSERT_TRUE(png) << png.error().message;
  EXPECT_GT(InkOf(Decode(png.value()), cv::Vec3b(0xB2, 0x72, 0x00)), 10'000) << "the full cell";
}

TEST(FigureJson, IsPlainTextAndNullForNan) {
  const boost::json::object json = ToJson(SmallFigure());
  EXPECT_EQ(json.at("subtitle"), "R1 = 100 Ω");
  const boost::json::value& series = json.at("panels").at(0).at("series").at(0);
  EXPECT_TRUE(series.at("y").at(100).is_null());
  EXPECT_EQ(series.at("ink"), "blue");
  EXPECT_EQ(series.at("x").as_array().size(), 200u);
  EXPECT_EQ(json.at("marks").at(1).at("kind"), "detected");
  EXPECT_EQ(json.at("panels").at(0).at("y").at("label"), "Um");
  EXPECT_EQ(boost::json::serialize(json).find("NaN"), std::string::npos);
}

}  // namespace
}  // namespace faultlab::server
