#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace faultlab::server {

/// A drawing as data: its content, not its appearance. The OpenCV renderer makes the PNG from it,
/// the browser draws the same content from ToJson(). Text may contain subscripts as "b_{0d}";
/// PlainText() removes the mark-up for renderers without subscripts.
enum class Ink { kBlue, kVermilion, kGreen, kSky, kPurple, kOrange, kBlack, kGrey };
enum class Dash { kSolid, kDashed, kDotted };

struct Axis {
  std::string label;  ///< "U_{m}"
  std::string unit;   ///< "V"; empty for a pure number
  /// Fixed range; without it the renderer uses the range of the data, with a margin.
  std::optional<std::pair<double, double>> range;
};

/// x ascending; NaN in y breaks the line.
struct Series {
  std::string name;  ///< legend entry; empty: not in the legend
  Ink ink = Ink::kBlue;
  Dash dash = Dash::kSolid;
  double width = 1.6;         ///< points at scale 1
  bool stair = false;         ///< keeps its value until the next x (a control voltage)
  std::optional<bool> scale;  ///< false: not used for the automatic y range (default true)
  std::vector<double> x;
  std::vector<double> y;
};

/// A horizontal reference, such as a nominal value.
struct Level {
  double y = 0.0;
  std::string label;  ///< written at the right edge of the panel
  Ink ink = Ink::kGrey;
};

/// A shaded rectangle; an open side reaches the edge of the panel.
struct Band {
  std::optional<double> x_from, x_to, y_from, y_to;
  std::string name;  ///< legend entry
  Ink ink = Ink::kGrey;
};

/// A part of the panel's own series, magnified above them; Axis::range must leave room for it.
struct Inset {
  double x_from = 0.0;
  double x_to = 1.0;
};

enum class MarkKind { kFault, kDetected, kReturned };

/// An instant, drawn through all panels, distinguished by shape, dash and label, not only by
/// colour.
struct Mark {
  MarkKind kind = MarkKind::kFault;
  double x = 0.0;
  std::string label;
};

struct Panel {
  std::string title;  ///< "(a) R_{1}", above the panel; usually empty
  Axis y;
  std::vector<Series> series;
  std::vector<Level> levels;
  std::vector<Band> bands;
  std::optional<Inset> inset;
  double weight = 1.0;  ///< share of the height
};

/// A matrix as coloured cells (isolability). Replaces the panels when rows is not empty.
struct CellMatrix {
  std::vector<std::string> rows;
  std::vector<std::string> columns;
  std::vector<double> value;      ///< [rows x columns], 0 = pale .. 1 = full colour; NaN = empty
  std::vector<std::string> text;  ///< [rows x columns], written in the cell
  std::string row_title;
  std::string column_title;
};

/// A step of a procedure. Each but the first follows one other.
struct FlowStep {
  std::string text;
  int next = -1;       ///< place of the step that follows; of a question the one after "yes"
  int otherwise = -1;  ///< of a question, the one after "no"; -1: it is none
  bool taken = false;  ///< drawn as the way that was gone
};

struct Figure {
  std::string title;
  std::string subtitle;
  Axis x;
  std::vector<Panel> panels;
  std::vector<Mark> marks;
  CellMatrix matrix;
  std::vector<FlowStep> flow;  ///< a flow chart, the first step first; replaces the panels
  std::string footer;          ///< origin: rig, run, version
};

/// "b_{0d}" -> "b0d".
std::string PlainText(const std::string& text);

}  // namespace faultlab::server
