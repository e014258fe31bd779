#include "server/plots/figure_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/types/check.h"
#include "server/plots/ticks.h"
#include "server/plots/value_text.h"

namespace faultlab::server {
namespace {

std::string FaultLabel(const core::Fault& fault) {
  std::string text =
      ComponentLabel(fault.component) + " = " + ValueText(fault.value, core::Unit(fault.component));
  if (fault.kind == core::FaultKind::kDrift) {
    text += " (drift to " + FormatNumber(fault.until_s, 1) + " s)";
  }
  return text;
}

constexpr double kSameS = 1e-6;  // times that went through JSON are equal within this

bool IsNominal(const core::Fault& fault) {
  return fault.value == fault.component.info().nominal;
}

/// "R_{12} = 5.59 kΩ", "R_{9}/R_{12}"; empty when no component was named.
std::string Named(const core::Verdict& verdict) {
  if (verdict.kind != core::VerdictKind::kFault || verdict.candidates.empty()) return {};
  if (verdict.group.size() <= 1) {
    const core::Candidate& best = verdict.candidates.front();
    const char* relation = best.bound == 0 ? " = " : best.bound == '<' ? " < " : " > ";
    return ComponentLabel(best.component) + relation +
           ValueText(best.value, core::Unit(best.component));
  }
  std::string named;
  for (const core::Component component : verdict.group) {
    named += (named.empty() ? "" : "/") + ComponentLabel(component);
  }
  return named;
}

/// "detected +0.02 s": since the change that was the last before it.
std::string DetectedLabel(double at_s, const FigureContext& context) {
  const std::vector<double> changes = ReportedChanges(context);
  const auto after = std::upper_bound(changes.begin(), changes.end(), at_s + kSameS);
  return after == changes.begin()
             ? "detected at " + FormatNumber(at_s, 2) + " s"
             : "detected +" + FormatNumber(std::max(0.0, at_s - *std::prev(after)), 2) + " s";
}

}  // namespace

std::vector<Mark> MakeMarks(const FigureContext& context) {
  std::vector<Mark> marks;
  for (const core::Fault& fault : context.faults) {
    const std::string returned = ComponentLabel(fault.component) + " nominal";
    if (IsNominal(fault)) {
      marks.push_back({MarkKind::kReturned, fault.at_s, returned});
      continue;
    }
    marks.push_back({MarkKind::kFault, fault.at_s, FaultLabel(fault)});
    if (fault.kind == core::FaultKind::kIntermittent) {
      marks.push_back({MarkKind::kReturned, fault.until_s, returned});
    }
  }
  const auto detected = [&](double at_s, const std::string& named) {
    const std::string label = DetectedLabel(at_s, context);
    marks.push_back({MarkKind::kDetected, at_s, named.empty() ? label : label + ": " + named});
  };
  for (std::size_t i = 0; i < context.episodes.size(); ++i) {
    const core::FaultEpisode& episode = context.episodes[i];
    const std::vector<core::Detection> detections = core::DetectionsOf(episode.verdict);
    for (std::size_t k = 0; k < detections.size(); ++k) {
      // The value is what is known since the newest.
      const bool newest = k + 1 == detections.size();
      detected(detections[k].detected_at_s, newest ? Named(episode.verdict) : "");
    }
    const bool next_begins = i + 1 < context.episodes.size() &&
                             context.episodes[i + 1].verdict.detected_at_s == episode.ended_at_s;
    if (episode.ended_at_s && !next_begins) detected(*episode.ended_at_s, "nominal");
  }
  return marks;
}

std::vector<double> ReportedChanges(const FigureContext& context) {
  std::vector<double> changes;
  for (const core::Fault& fault : context.faults) {
    changes.push_back(fault.at_s);
    if (fault.kind == core::FaultKind::kIntermittent) changes.push_back(fault.until_s);
  }
  std::ranges::sort(changes);
  return changes;
}

std::vector<double> ChangeTimes(const FigureContext& context) {
  if (!context.faults.empty()) return ReportedChanges(context);
  std::vector<double> changes;
  for (const core::FaultEpisode& episode : context.episodes) {
    for (const core::Detection& one : core::DetectionsOf(episode.verdict)) {
      changes.push_back(one.onset_s.value_or(one.detected_at_s));
    }
    if (episode.ended_at_s) changes.push_back(*episode.ended_at_s);
  }
  std::ranges::sort(changes);
  changes.erase(std::unique(changes.begin(), changes.end()), changes.end());
  return changes;
}

Figure MakeFigureOf(const std::string& title, const FigureContext& context) {
  Figure figure;
  figure.title = title;
  figure.subtitle = context.name;
  figure.x = {"Time t", "s", std::nullopt};
  figure.marks = MakeMarks(context);
  figure.footer = context.footer;
  return figure;
}

void AddLens(Panel& panel, double from) {
  constexpr double kRoom = 1.9;  // free space above the data, in heights of the data
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Series& series : panel.series) {
    for (const double y : series.y) {
      if (!std::isfinite(y)) continue;
      low = std::min(low, y);
      high = std::max(high, y);
    }
  }
  const double span = high - low;
  if (!(span > 0.0)) return;
  panel.inset = Inset{from, from + kLensSeconds};
  panel.y.range = {low - 0.15 * span, high + kRoom * span};
}

double MeanPeriod(const core::Sample& first, const core::Sample& last) {
  LAB_CHECK(last.index > first.index, first.index, last.index);
  return (last.t_s - first.t_s) / static_cast<double>(last.index - first.index);
}

std::pair<double, double> WholeTime(const core::Sample& first, const core::Sample& last) {
  return {first.t_s, last.t_s + MeanPeriod(first, last)};
}

Series MakeChannelSeries(std::span<const core::Sample> samples,
                         double core::Sample::*channel,
                         Ink ink) {
  Series series;
  series.ink = ink;
  series.x.reserve(samples.size());
  series.y.reserve(samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (k > 0 && samples[k].index > samples[k - 1].index + 1) {
      series.x.push_back(samples[k].t_s);
      series.y.push_back(core::kAbsent);
    }
    series.x.push_back(samples[k].t_s);
    series.y.push_back(samples[k].*channel);
  }
  return series;
}

}  // namespace faultlab::server
