#include "server/plots/figure_parts.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

std::vector<Mark> MakeMarks(const FigureContext& context) {
  std::vector<Mark> marks;
  for (const core::Fault& fault : context.faults) {
    marks.push_back({MarkKind::kFault, fault.at_s, FaultLabel(fault)});
    if (fault.kind == core::FaultKind::kIntermittent) {
      marks.push_back(
          {MarkKind::kReturned, fault.until_s, ComponentLabel(fault.component) + " nominal"});
    }
  }
  if (context.verdict && context.verdict->detected_at_s) {
    const double at = *context.verdict->detected_at_s;
    std::string label = "detected";
    const std::optional<double> change =
        context.faults.empty() ? std::nullopt : std::optional(context.faults.front().at_s);
    if (change && at >= *change) {
      label += " +" + FormatNumber(at - *change, 2) + " s";
    } else {
      label += " at " + FormatNumber(at, 2) + " s";
    }
    if (!context.verdict->candidates.empty() &&
        context.verdict->kind == core::VerdictKind::kFault) {
      const core::Candidate& best = context.verdict->candidates.front();
      std::string named;
      for (const core::Component component : context.verdict->group) {
        named += (named.empty() ? "" : "/") + ComponentLabel(component);
      }
      if (context.verdict->group.size() <= 1) {
        const char* relation = best.bound == 0 ? " = " : best.bound == '<' ? " < " : " > ";
        named = ComponentLabel(best.component) + relation +
                ValueText(best.value, core::Unit(best.component));
      }
      label += ": " + named;
    }
    marks.push_back({MarkKind::kDetected, at, label});
  }
  return marks;
}

std::optional<double> FirstChange(const FigureContext& context) {
  if (!context.faults.empty()) {
    return context.faults.front().at_s;
  }
  if (context.verdict && context.verdict->onset_s) {
    return context.verdict->onset_s;
  }
  return context.verdict ? context.verdict->detected_at_s : std::nullopt;
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
