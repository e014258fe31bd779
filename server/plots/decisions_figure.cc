#include <string>
#include <vector>

#include "core/paper/decisions.h"
#include "server/plots/figure_parts.h"
#include "server/plots/value_text.h"

namespace faultlab::server {
namespace {

std::string EndText(const core::Decision& end) {
  if (end.healthy) return "no fault";
  std::string text;
  for (const core::Component component : end.components) {
    text += (text.empty() ? "" : " or ") + ComponentLabel(component);
  }
  return text.empty() ? "none of the components" : text;
}

/// The path of the newest verdict that has one; a rig that is healthy again has had it.
const std::vector<core::PathStep>* NewestPath(const core::Diagnosis& diagnosis) {
  if (!diagnosis.verdict.path.empty()) return &diagnosis.verdict.path;
  for (auto each = diagnosis.episodes.rbegin(); each != diagnosis.episodes.rend(); ++each) {
    if (!each->verdict.path.empty()) return &each->verdict.path;
  }
  return nullptr;
}

Figure MakeFlowFigure(const std::string& title, const FigureContext& context) {
  Figure figure = MakeFigureOf(title, context);
  figure.x = {};
  figure.marks.clear();
  return figure;
}

}  // namespace

Figure MakeStepsFigure(const core::Diagnosis& diagnosis, const FigureContext& context) {
  Figure figure = MakeFlowFigure("From a healthy rig to the value of a fault", context);
  figure.flow = {{"Excite the rig: PRBS on U_{c}; record U_{c} and U_{m}", 1},
                 {"Estimate b_{0}, b_{1}, a_{1} in a sliding window (SWA, SIA)", 2},
                 {"Detection: one of them outside the band of the healthy rig?", 4, 3},
                 {"no fault: the window slides on"},
                 {"Isolation: which component? The decisions of Figure 21", 5},
                 {"Identification: its value by Equations (4) and (7), or (42)"}};
  const std::vector<core::PathStep>* path = NewestPath(diagnosis);
  const bool nominal = path == nullptr && diagnosis.verdict.kind == core::VerdictKind::kNominal;
  if (path == nullptr && !nominal) return figure;
  const bool found = !nominal && (path->front().answer || path->size() > 1);
  const bool named = found && !path->back().components.empty();
  figure.flow[0].taken = figure.flow[1].taken = figure.flow[2].taken = true;
  figure.flow[3].taken = !found;
  figure.flow[4].taken = found;
  figure.flow[5].taken = named;
  return figure;
}

Figure MakeDecisionsFigure(const core::Bench& bench,
                           const core::Diagnosis& diagnosis,
                           const FigureContext& context) {
  Figure figure = MakeFlowFigure("Decisions of the paper (Figure 21)", context);
  for (const core::Decision& each : core::DecisionsOf(bench)) {
    const bool end = each.yes < 0;
    figure.flow.push_back(
        {end ? EndText(each) : std::string(each.question), each.yes, each.no, false});
  }
  const std::vector<core::PathStep>* path = NewestPath(diagnosis);
  if (path == nullptr) return figure;
  std::size_t at = 0;
  figure.flow[at].taken = true;
  for (const core::PathStep& step : *path) {
    const int next = step.answer ? figure.flow[at].next : figure.flow[at].otherwise;
    if (next < 0) break;
    at = static_cast<std::size_t>(next);
    figure.flow[at].taken = true;
  }
  return figure;
}

}  // namespace faultlab::server
