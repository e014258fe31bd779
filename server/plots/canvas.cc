#include "server/plots/canvas.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace faultlab::server {
namespace {

constexpr int kShift = 4;  // fractional bits of a coordinate
constexpr double kSubPixels = 1 << kShift;
constexpr double kFarAway = 30'000.0;    // keeps coordinates inside OpenCV's fixed point
constexpr double kCapitalHeight = 0.73;  // of the size, DejaVu Sans

cv::Scalar Pen(Rgb colour) {
  return {static_cast<double>(colour.red),
          static_cast<double>(colour.green),
          static_cast<double>(colour.blue)};
}

/// The centre of pixel (0, 0) is (0, 0) in OpenCV and (0.5, 0.5) here.
cv::Point Fixed(PixelPoint point, int left = 0, int top = 0) {
  const auto fix = [](double value) {
    return static_cast<int>(
        std::lround((std::clamp(value, -kFarAway, kFarAway) - 0.5) * kSubPixels));
  };
  return {fix(point.x - left), fix(point.y - top)};
}

cv::Rect Inside(const PixelRect& rect, const cv::Mat& image) {
  return cv::Rect(rect.left, rect.top, std::max(0, rect.width), std::max(0, rect.height)) &
         cv::Rect(0, 0, image.cols, image.rows);
}

/// Cuts a line into the strokes of a dash pattern.
std::vector<std::vector<PixelPoint>> CutIntoDashes(std::span<const PixelPoint> points,
                                                   double on,
                                                   double off) {
  std::vector<std::vector<PixelPoint>> dashes;
  if (points.empty()) {
    return dashes;
  }
  bool drawing = true;
  double left = on;
  dashes.push_back({points.front()});
  for (std::size_t i = 1; i < points.size(); ++i) {
    PixelPoint from = points[i - 1];
    const PixelPoint to = points[i];
    double length = std::hypot(to.x - from.x, to.y - from.y);
    if (length > kFarAway) {
      length = 0.0;  // stop: a line far outside the picture would make a million dashes
    }
    while (length > left) {
      const double share = left / length;
      from = {from.x + share * (to.x - from.x), from.y + share * (to.y - from.y)};
      length -= left;
      if (drawing) {
        dashes.back().push_back(from);
      } else {
        dashes.push_back({from});
      }
      drawing = !drawing;
      left = drawing ? on : off;
    }
    left -= length;
    if (drawing) {
      dashes.back().push_back(to);
    }
  }
  return dashes;
}

}  // namespace

// The page draws with the same colours: web/src/theme/inks.ts, compared by web/tests/inks.test.ts.
Rgb ColourOf(Ink ink) {
  switch (ink) {
    case Ink::kBlue:
      return {0x00, 0x72, 0xB2};
    case Ink::kVermilion:
      return {0xD5, 0x5E, 0x00};
    case Ink::kGreen:
      return {0x00, 0x9E, 0x73};
    case Ink::kSky:
      return {0x0A, 0x98, 0xD6};
    case Ink::kPurple:
      return {0xAA, 0x44, 0x99};
    case Ink::kOrange:
      return {0xB5, 0x7A, 0x00};
    case Ink::kBlack:
      return {0x11, 0x11, 0x11};
    case Ink::kGrey:
      return {0x77, 0x77, 0x77};
  }
  return {};
}

Rgb Tint(Rgb colour, double share) {
  const auto mix = [share](int part) {
    return static_cast<int>(std::lround(255.0 + share * (part - 255.0)));
  };
  return {mix(colour.red), mix(colour.green), mix(colour.blue)};
}

Canvas::Canvas(int width, int height, Typeface& type)
    : image_(height, width, CV_8UC3, cv::Scalar::all(255)), type_(&type) {}

void Canvas::Fill(const PixelRect& rect, Rgb colour) {
  image_(Inside(rect, image_)).setTo(Pen(colour));
}

void Canvas::Shade(const PixelRect& rect, Rgb colour, double share) {
  const cv::Rect region = Inside(rect, image_);
  if (region.empty()) return;  // OpenCV refuses to add to an image without pixels
  cv::Mat part = image_(region);
  part.convertTo(part, -1, 1.0 - share);
  part += Pen(colour) * share;
}

void Canvas::Frame(const PixelRect& rect, const Stroke& stroke) {
  cv::rectangle(image_,
                cv::Rect(rect.left, rect.top, rect.width, rect.height),
                Pen(stroke.colour),
                stroke.width_px);
}

void Canvas::Line(PixelPoint from, PixelPoint to, const Stroke& stroke) {
  const PixelPoint points[] = {from, to};
  Polyline(points, stroke, {0, 0, image_.cols, image_.rows});
}

void Canvas::Polyline(std::span<const PixelPoint> points,
                      const Stroke& stroke,
                      const PixelRect& clip) {
  if (stroke.dash != Dash::kSolid) {
    const bool dotted = stroke.dash == Dash::kDotted;
    const double on = stroke.dash_unit_px * (dotted ? 0.5 : 2.5);
    const double off = stroke.dash_unit_px * (dotted ? 1.0 : 1.5);
    Stroke solid = stroke;
    solid.dash = Dash::kSolid;
    for (const std::vector<PixelPoint>& dash : CutIntoDashes(points, on, off)) {
      Polyline(dash, solid, clip);
    }
    return;
  }
  const cv::Rect region = Inside(clip, image_);
  if (region.empty() || points.empty()) {
    return;
  }
  std::vector<cv::Point> fixed;
  fixed.reserve(points.size());
  for (const PixelPoint& point : points) {
    fixed.push_back(Fixed(point, region.x, region.y));
  }
  cv::Mat part = image_(region);
  cv::polylines(part, fixed, false, Pen(stroke.colour), stroke.width_px, cv::LINE_AA, kShift);
}

void Canvas::Polygon(std::span<const PixelPoint> points, Rgb colour) {
  std::vector<cv::Point> fixed;
  for (const PixelPoint& point : points) {
    fixed.push_back(Fixed(point));
  }
  cv::fillConvexPoly(image_, fixed, Pen(colour), cv::LINE_AA, kShift);
}

void Canvas::Disc(PixelPoint centre, double radius, Rgb colour) {
  cv::circle(image_,
             Fixed(centre),
             static_cast<int>(std::lround(radius * kSubPixels)),
             Pen(colour),
             cv::FILLED,
             cv::LINE_AA,
             kShift);
}

void Canvas::Text(
    std::string_view text, double x, double middle_y, int size_px, Rgb colour, Align align) {
  if (text.empty()) {
    return;
  }
  TextBitmap bitmap = type_->Draw(text, size_px);
  const int width = type_->Width(text, size_px);
  const double left = align == Align::kLeft     ? x
                      : align == Align::kCentre ? x - 0.5 * width
                                                : x - width;
  const double baseline = middle_y + 0.5 * kCapitalHeight * size_px;
  const cv::Mat coverage(bitmap.height, bitmap.width, CV_8UC1, bitmap.coverage.data());
  Blend(coverage,
        static_cast<int>(std::lround(left)),
        static_cast<int>(std::lround(baseline)) - bitmap.baseline,
        colour);
}

void Canvas::VerticalText(std::string_view text, double x, double y, int size_px, Rgb colour) {
  if (text.empty()) {
    return;
  }
  TextBitmap bitmap = type_->Draw(text, size_px);
  const cv::Mat coverage(bitmap.height, bitmap.width, CV_8UC1, bitmap.coverage.data());
  cv::Mat turned;
  cv::rotate(coverage, turned, cv::ROTATE_90_COUNTERCLOCKWISE);
  const double capitals_middle = bitmap.baseline - 0.5 * kCapitalHeight * size_px;
  Blend(turned,
        static_cast<int>(std::lround(x - capitals_middle)),
        static_cast<int>(std::lround(y - 0.5 * turned.rows)),
        colour);
}

void Canvas::Blend(const cv::Mat& coverage, int left, int top, Rgb colour) {
  const cv::Rect target =
      cv::Rect(left, top, coverage.cols, coverage.rows) & cv::Rect(0, 0, image_.cols, image_.rows);
  const std::array<int, 3> pen = {colour.red, colour.green, colour.blue};
  constexpr int kFull = 255;
  for (int y = target.y; y < target.y + target.height; ++y) {
    const std::uint8_t* ink = coverage.ptr<std::uint8_t>(y - top);
    std::uint8_t* paper = image_.ptr<std::uint8_t>(y);
    for (int x = target.x; x < target.x + target.width; ++x) {
      const int share = ink[x - left];
      for (int part = 0; share > 0 && part < 3; ++part) {
        std::uint8_t& value = paper[3 * x + part];
        const int mixed = value * (kFull - share) + pen[static_cast<std::size_t>(part)] * share;
        value = static_cast<std::uint8_t>((mixed + kFull / 2) / kFull);
      }
    }
  }
}

std::span<const std::uint8_t> Canvas::pixels() const {
  return {image_.data, image_.total() * image_.elemSize()};
}

}  // namespace faultlab::server
