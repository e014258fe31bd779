#include "server/plots/figure_json.h"

#include <boost/json/array.hpp>
#include <boost/json/value.hpp>
#include <string_view>

#include "server/json/number_or_null.h"
#include "server/plots/thinned.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

std::string_view Name(Ink ink) {
  switch (ink) {
    case Ink::kBlue:
      return "blue";
    case Ink::kVermilion:
      return "vermilion";
    case Ink::kGreen:
      return "green";
    case Ink::kSky:
      return "sky";
    case Ink::kPurple:
      return "purple";
    case Ink::kOrange:
      return "orange";
    case Ink::kBlack:
      return "black";
    case Ink::kGrey:
      return "grey";
  }
  return "?";
}

std::string_view Name(Dash dash) {
  switch (dash) {
    case Dash::kSolid:
      return "solid";
    case Dash::kDashed:
      return "dashed";
    case Dash::kDotted:
      return "dotted";
  }
  return "?";
}

std::string_view Name(MarkKind kind) {
  switch (kind) {
    case MarkKind::kFault:
      return "fault";
    case MarkKind::kDetected:
      return "detected";
    case MarkKind::kReturned:
      return "returned";
  }
  return "?";
}

json::array Numbers(const std::vector<double>& values) {
  json::array out;
  out.reserve(values.size());
  for (const double value : values) {
    out.push_back(NumberOrNull(value));
  }
  return out;
}

json::array Strings(const std::vector<std::string>& texts) {
  json::array out;
  for (const std::string& text : texts) {
    out.emplace_back(PlainText(text));
  }
  return out;
}

json::object ToJson(const Axis& axis) {
  json::object out = {{"label", PlainText(axis.label)}, {"unit", axis.unit}};
  out["range"] =
      axis.range ? json::value{axis.range->first, axis.range->second} : json::value(nullptr);
  return out;
}

json::object ToJson(const Series& whole, const std::optional<Inset>& inset) {
  const Series series = Thinned(whole, inset);
  return {{"name", PlainText(series.name)},
          {"ink", Name(series.ink)},
          {"dash", Name(series.dash)},
          {"width", series.width},
          {"stair", series.stair},
          {"x", Numbers(series.x)},
          {"y", Numbers(series.y)}};
}

json::object ToJson(const Panel& panel) {
  json::array series;
  for (const Series& one : panel.series) {
    series.emplace_back(ToJson(one, panel.inset));
  }
  json::array levels;
  for (const Level& level : panel.levels) {
    levels.emplace_back(json::object{
        {"y", NumberOrNull(level.y)}, {"label", PlainText(level.label)}, {"ink", Name(level.ink)}});
  }
  json::array bands;
  for (const Band& band : panel.bands) {
    bands.emplace_back(json::object{{"name", PlainText(band.name)},
                                    {"ink", Name(band.ink)},
                                    {"x_from", NumberOrNull(band.x_from)},
                                    {"x_to", NumberOrNull(band.x_to)},
                                    {"y_from", NumberOrNull(band.y_from)},
                                    {"y_to", NumberOrNull(band.y_to)}});
  }
  json::value inset = nullptr;
  if (panel.inset) {
    inset = json::object{{"x_from", panel.inset->x_from}, {"x_to", panel.inset->x_to}};
  }
  return {{"title", PlainText(panel.title)},
          {"y", ToJson(panel.y)},
          {"weight", panel.weight},
          {"series", std::move(series)},
          {"levels", std::move(levels)},
          {"bands", std::move(bands)},
          {"inset", std::move(inset)}};
}

json::object ToJson(const CellMatrix& matrix) {
  return {{"rows", Strings(matrix.rows)},
          {"columns", Strings(matrix.columns)},
          {"value", Numbers(matrix.value)},
          {"text", Strings(matrix.text)},
          {"row_title", PlainText(matrix.row_title)},
          {"column_title", PlainText(matrix.column_title)}};
}

}  // namespace

json::object ToJson(const Figure& figure) {
  json::array panels;
  for (const Panel& panel : figure.panels) {
    panels.emplace_back(ToJson(panel));
  }
  json::array marks;
  for (const Mark& mark : figure.marks) {
    marks.emplace_back(json::object{
        {"kind", Name(mark.kind)}, {"x", NumberOrNull(mark.x)}, {"label", PlainText(mark.label)}});
  }
  json::object out = {{"title", PlainText(figure.title)},
                      {"subtitle", PlainText(figure.subtitle)},
                      {"x", ToJson(figure.x)},
                      {"panels", std::move(panels)},
                      {"marks", std::move(marks)},
                      {"footer", figure.footer}};
  if (!figure.matrix.rows.empty()) {
    out["matrix"] = ToJson(figure.matrix);
  }
  return out;
}

}  // namespace faultlab::server
