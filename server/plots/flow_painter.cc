#include "server/plots/flow_painter.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/types/check.h"

namespace faultlab::server {
namespace {

constexpr Rgb kWay = {0x00, 0x72, 0xB2};
constexpr double kBoxShare = 0.78;  // of a column; the rest is for the lines
constexpr double kRowShare = 0.74;  // of a row
constexpr double kHighest = 96.0;   // of a box, at scale 1
constexpr Rgb kEndGround = {0xF2, 0xF2, 0xF2};
constexpr std::size_t kLinesMax = 4;

/// Where a step stands: its column, and its row in units of ends.
struct Place {
  int column = 0;
  double row = 0.0;
};

class FlowPainter {
 public:
  FlowPainter(Canvas& canvas,
              const PlotStyle& style,
              const std::vector<FlowStep>& steps,
              const PixelRect& area)
      : canvas_(canvas), style_(style), steps_(steps), area_(area), places_(steps.size()) {
    (void)Settle(0, 0);
  }

  void Draw() {
    for (const bool taken : {false, true}) {  // the way lies above the others
      for (std::size_t i = 0; i < steps_.size(); ++i) {
        const FlowStep& step = steps_[i];
        Connect(i, step.next, step.otherwise >= 0 ? "yes" : "", taken);
        Connect(i, step.otherwise, "no", taken);
      }
    }
    for (std::size_t i = 0; i < steps_.size(); ++i) DrawBox(i);
  }

 private:
  /// Places a step and all that follow it. @returns its row
  double Settle(int at, int column) {
    LAB_CHECK(
        at >= 0 && at < static_cast<int>(steps_.size()) && column < static_cast<int>(steps_.size()),
        at,
        column);
    const FlowStep& step = steps_[static_cast<std::size_t>(at)];
    columns_ = std::max(columns_, column + 1);
    double row = 0.0;
    if (step.next < 0) {
      row = ends_++;
    } else {
      row = Settle(step.next, column + 1);
      if (step.otherwise >= 0) row = 0.5 * (row + Settle(step.otherwise, column + 1));
    }
    places_[static_cast<std::size_t>(at)] = {column, row};
    return row;
  }

  PixelRect BoxOf(std::size_t i) const {
    const double width = static_cast<double>(area_.width) / columns_;
    const double height = static_cast<double>(area_.height) / std::max(1, ends_);
    const double box_height =
        std::min(kRowShare * height, static_cast<double>(style_.Px(kHighest)));
    const double middle = area_.top + (places_[i].row + 0.5) * height;
    return {area_.left + static_cast<int>(width * places_[i].column),
            static_cast<int>(middle - 0.5 * box_height),
            static_cast<int>(kBoxShare * width),
            static_cast<int>(box_height)};
  }

  Stroke StrokeOf(bool taken) const {
    return {taken ? kWay : kQuietColour, taken ? 3 * style_.line_px : style_.line_px};
  }

  void Connect(std::size_t from, int to, const std::string& word, bool taken) {
    if (to < 0) return;
    const auto next = static_cast<std::size_t>(to);
    if ((steps_[from].taken && steps_[next].taken) != taken) return;
    const PixelRect a = BoxOf(from);
    const PixelRect b = BoxOf(next);
    const double y_a = a.top + 0.5 * a.height;
    const double y_b = b.top + 0.5 * b.height;
    const double x = a.right() + 0.35 * (b.left - a.right());
    const Stroke stroke = StrokeOf(taken);
    canvas_.Line({1.0 * a.right(), y_a}, {x, y_a}, stroke);
    canvas_.Line({x, y_a}, {x, y_b}, stroke);
    canvas_.Line({x, y_b}, {1.0 * b.left, y_b}, stroke);
    if (word.empty()) return;
    canvas_.Text(word,
                 b.left - style_.Px(6),
                 y_b - 0.7 * style_.tick_px,
                 style_.tick_px,
                 taken ? kWay : kQuietColour,
                 Align::kRight);
  }

  /// The words in as many lines as the width needs.
  std::vector<std::string> LinesOf(const std::string& text, int width) {
    std::vector<std::string> lines = {""};
    for (std::size_t from = 0; from < text.size();) {
      const std::size_t end = std::min(text.find(' ', from), text.size());
      const std::string word = text.substr(from, end - from);
      const std::string longer = lines.back().empty() ? word : lines.back() + " " + word;
      const bool fits = canvas_.TextWidth(longer, style_.tick_px) <= width;
      if (fits || lines.back().empty() || lines.size() == kLinesMax) {
        lines.back() = longer;
      } else {
        lines.push_back(word);
      }
      from = end + 1;
    }
    return lines;
  }

  void DrawBox(std::size_t i) {
    const FlowStep& step = steps_[i];
    const PixelRect box = BoxOf(i);
    const bool end = step.next < 0;
    canvas_.Fill(box, step.taken ? Tint(kWay, 0.14) : end ? kEndGround : kPaper);
    canvas_.Frame(box, StrokeOf(step.taken));
    const std::vector<std::string> lines = LinesOf(step.text, box.width - style_.Px(12));
    const double line_px = 1.25 * style_.tick_px;
    double y = box.top + 0.5 * box.height - 0.5 * line_px * static_cast<double>(lines.size() - 1);
    for (const std::string& line : lines) {
      canvas_.Text(
          line, box.left + 0.5 * box.width, y, style_.tick_px, kTextColour, Align::kCentre);
      y += line_px;
    }
  }

  Canvas& canvas_;
  const PlotStyle& style_;
  const std::vector<FlowStep>& steps_;
  const PixelRect area_;
  std::vector<Place> places_;
  int columns_ = 1;
  int ends_ = 0;
};

}  // namespace

void DrawFlow(Canvas& canvas,
              const PlotStyle& style,
              const std::vector<FlowStep>& steps,
              const PixelRect& area) {
  LAB_CHECK(!steps.empty());
  const int room = style.Px(12);
  FlowPainter(
      canvas, style, steps, {area.left, area.top + room, area.width, area.height - 2 * room})
      .Draw();
}

}  // namespace faultlab::server
