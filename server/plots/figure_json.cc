#include "server/plots/figure_json.h"

#include <array>
#include <boost/json/array.hpp>
#include <boost/json/value.hpp>
#include <string_view>

#include "server/json/number_or_null.h"
#include "server/plots/thinned.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

std::string_view Name(Ink ink) {
  constexpr std::array<std::string_view, 8> kNames = {
      "blue", "vermilion", "green", "sky", "purple", "orange", "black", "grey"};
  return kNames[static_cast<std::size_t>(ink)];
}

std::string_view Name(Dash dash) {
  constexpr std::array<std::string_view, 3> kNames = {"solid", "dashed", "dotted"};
  return kNames[static_cast<std::size_t>(dash)];
}

std::string_view Name(MarkKind kind) {
  constexpr std::array<std::string_view, 3> kNames = {"fault", "detected", "returned"};
  return kNames[static_cast<std::size_t>(kind)];
}

json::array Strings(const std::vector<std::string>& texts) {
  return ListOf(texts, [](const std::string& text) { return PlainText(text); });
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
          {"x", NumbersOrNull(series.x)},
          {"y", NumbersOrNull(series.y)}};
}

json::object ToJson(const Panel& panel) {
  const auto series = [&](const Series& one) { return ToJson(one, panel.inset); };
  const auto level = [](const Level& one) {
    return json::object{
        {"y", NumberOrNull(one.y)}, {"label", PlainText(one.label)}, {"ink", Name(one.ink)}};
  };
  const auto band = [](const Band& one) {
    return json::object{{"name", PlainText(one.name)},
                        {"ink", Name(one.ink)},
                        {"x_from", NumberOrNull(one.x_from)},
                        {"x_to", NumberOrNull(one.x_to)},
                        {"y_from", NumberOrNull(one.y_from)},
                        {"y_to", NumberOrNull(one.y_to)}};
  };
  json::value inset = nullptr;
  if (panel.inset) {
    inset = json::object{{"x_from", panel.inset->x_from}, {"x_to", panel.inset->x_to}};
  }
  return {{"title", PlainText(panel.title)},
          {"y", ToJson(panel.y)},
          {"weight", panel.weight},
          {"series", ListOf(panel.series, series)},
          {"levels", ListOf(panel.levels, level)},
          {"bands", ListOf(panel.bands, band)},
          {"inset", std::move(inset)}};
}

json::object ToJson(const CellMatrix& matrix) {
  return {{"rows", Strings(matrix.rows)},
          {"columns", Strings(matrix.columns)},
          {"value", NumbersOrNull(matrix.value)},
          {"text", Strings(matrix.text)},
          {"row_title", PlainText(matrix.row_title)},
          {"column_title", PlainText(matrix.column_title)}};
}

}  // namespace

json::object ToJson(const Figure& figure) {
  const auto panel = [](const Panel& one) { return ToJson(one); };
  const auto mark = [](const Mark& one) {
    return json::object{
        {"kind", Name(one.kind)}, {"x", NumberOrNull(one.x)}, {"label", PlainText(one.label)}};
  };
  json::object out = {{"title", PlainText(figure.title)},
                      {"subtitle", PlainText(figure.subtitle)},
                      {"x", ToJson(figure.x)},
                      {"panels", ListOf(figure.panels, panel)},
                      {"marks", ListOf(figure.marks, mark)},
                      {"footer", figure.footer}};
  if (!figure.matrix.rows.empty()) {
    out["matrix"] = ToJson(figure.matrix);
  }
  if (!figure.flow.empty()) {
    out["flow"] = ListOf(figure.flow, [](const FlowStep& step) {
      const auto place = [](int at) { return at < 0 ? json::value(nullptr) : json::value(at); };
      return json::object{{"text", PlainText(step.text)},
                          {"next", place(step.next)},
                          {"otherwise", place(step.otherwise)},
                          {"taken", step.taken}};
    });
  }
  return out;
}

}  // namespace faultlab::server
