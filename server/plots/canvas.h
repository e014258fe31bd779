#pragma once

#include <opencv2/core/mat.hpp>
#include <span>
#include <string_view>

#include "server/plots/figure.h"
#include "server/plots/typeface.h"

namespace faultlab::server {

struct Rgb {
  int red = 0;
  int green = 0;
  int blue = 0;
};

/// Okabe-Ito colours, readable for colour-blind people; the page uses the same values.
Rgb ColourOf(Ink ink);
/// `share` of the colour on white paper.
Rgb Tint(Rgb colour, double share);
inline constexpr Rgb kTextColour = {0x22, 0x22, 0x22};
inline constexpr Rgb kQuietColour = {0x66, 0x66, 0x66};
inline constexpr Rgb kGridColour = {0xDD, 0xDD, 0xDD};
inline constexpr Rgb kPaper = {0xFF, 0xFF, 0xFF};

struct PixelPoint {
  double x = 0.0;
  double y = 0.0;
};

struct PixelRect {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;
  int right() const { return left + width; }
  int bottom() const { return top + height; }
};

enum class Align { kLeft, kCentre, kRight };

struct Stroke {
  Rgb colour;
  int width_px = 1;
  Dash dash = Dash::kSolid;
  double dash_unit_px = 4.0;
};

/// A white picture on which a plot is drawn. Pixels count from the top left corner; lines are
/// antialiased with 1/16 pixel.
class Canvas {
 public:
  /// `type` must outlive the canvas.
  Canvas(int width, int height, Typeface& type);

  void Fill(const PixelRect& rect, Rgb colour);
  /// Blends `share` of the colour over the picture; overlapping shades become darker.
  void Shade(const PixelRect& rect, Rgb colour, double share);
  void Frame(const PixelRect& rect, const Stroke& stroke);
  void Line(PixelPoint from, PixelPoint to, const Stroke& stroke);
  /// Connected line through `points`; parts outside `clip` are not drawn.
  void Polyline(std::span<const PixelPoint> points, const Stroke& stroke, const PixelRect& clip);
  void Polygon(std::span<const PixelPoint> points, Rgb colour);
  void Disc(PixelPoint centre, double radius, Rgb colour);
  /// `x` is the left edge, centre or right edge of the text; `middle_y` is the middle of its
  /// capitals.
  void Text(std::string_view text,
            double x,
            double middle_y,
            int size_px,
            Rgb colour,
            Align align = Align::kLeft);
  /// Text that reads from bottom to top, centred on (x, y).
  void VerticalText(std::string_view text, double x, double y, int size_px, Rgb colour);
  int TextWidth(std::string_view text, int size_px) { return type_->Width(text, size_px); }

  /// RGB rows, top down.
  std::span<const std::uint8_t> pixels() const;
  int width() const { return image_.cols; }
  int height() const { return image_.rows; }

 private:
  void Blend(const cv::Mat& coverage, int left, int top, Rgb colour);

  cv::Mat image_;  // CV_8UC3, channels in the order red, green, blue
  Typeface* type_;
};

}  // namespace faultlab::server
