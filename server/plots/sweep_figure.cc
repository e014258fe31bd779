#include "server/plots/sweep_figure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/types/check.h"
#include "server/plots/ticks.h"
#include "server/plots/value_text.h"

namespace faultlab::server {
namespace {

/// The runs of one fault, in the order in which the sweep has them first.
struct SweepRow {
  std::string label;
  std::vector<const SweepRun*> runs;
};

std::string LabelOf(const SweepRun& run, bool with_value) {
  if (!run.component) return "healthy";
  const std::string name = ComponentLabel(*run.component);
  return with_value ? name + " = " + ValueText(run.value, core::Unit(*run.component)) : name;
}

std::vector<SweepRow> RowsOf(std::span<const SweepRun> runs, bool with_value) {
  std::vector<SweepRow> rows;
  for (const SweepRun& run : runs) {
    std::string label = LabelOf(run, with_value);
    const auto same = std::ranges::find(rows, label, &SweepRow::label);
    SweepRow& row = same != rows.end() ? *same : rows.emplace_back(SweepRow{std::move(label), {}});
    row.runs.push_back(&run);
  }
  return rows;
}

bool Names(const SweepRun& run, core::Component component) {
  return std::ranges::find(run.named, component) != run.named.end();
}

bool IsRight(const SweepRun& run) {
  return run.component && Names(run, *run.component);
}

/// The mean of what `of` says of the runs that it is known of; "" when there is none.
template <typename Of>
std::string MeanText(const SweepRow& row, int decimals, const Of& of) {
  double sum = 0.0;
  int count = 0;
  for (const SweepRun* run : row.runs) {
    const std::optional<double> value = of(*run);
    if (!value) continue;
    sum += *value;
    ++count;
  }
  return count == 0 ? std::string() : FormatNumber(sum / count, decimals);
}

std::optional<double> ErrorPercent(const SweepRun& run) {
  // of a group the value belongs to its first component only
  if (!IsRight(run) || run.named.size() != 1 || !run.found || run.value == 0.0) return {};
  return 100.0 * std::abs(*run.found - run.value) / std::abs(run.value);
}

}  // namespace

Figure MakeSweepFigure(std::span<const SweepRun> runs,
                       std::span<const core::Component> components,
                       const std::string& subtitle,
                       const std::string& footer) {
  std::vector<SweepRow> rows = RowsOf(runs, true);
  if (rows.size() > kSweepRowsMax) rows = RowsOf(runs, false);
  Figure figure;
  figure.title = "What was switched, and what was found";
  figure.subtitle = subtitle;
  figure.footer = footer;
  CellMatrix& matrix = figure.matrix;
  matrix.row_title = "Switched";
  matrix.column_title = "Found (share of the runs)";
  for (const core::Component component : components) {
    matrix.columns.push_back(ComponentLabel(component));
  }
  for (const char* more : {"unknown", "nothing", "delay (s)", "error (%)"}) {
    matrix.columns.emplace_back(more);
  }
  const auto number = [&](std::string text) {
    matrix.value.push_back(std::nan(""));
    matrix.text.push_back(std::move(text));
  };
  for (const SweepRow& row : rows) {
    matrix.rows.push_back(row.label + (row.runs.size() > 1
                                           ? " (" + std::to_string(row.runs.size()) + ")"
                                           : std::string()));
    const auto share = [&](const auto& of) {
      double sum = 0.0;
      for (const SweepRun* run : row.runs) sum += of(*run);
      const double part = sum / static_cast<double>(row.runs.size());
      matrix.value.push_back(part);
      matrix.text.push_back(part == 0.0 ? "" : FormatNumber(100.0 * part, 0) + " %");
    };
    for (const core::Component component : components) {
      share([&](const SweepRun& run) {
        return Names(run, component) ? 1.0 / static_cast<double>(run.named.size()) : 0.0;
      });
    }
    share([](const SweepRun& run) { return run.named.empty() && run.unknown ? 1.0 : 0.0; });
    share([](const SweepRun& run) { return run.named.empty() && !run.unknown ? 1.0 : 0.0; });
    number(MeanText(row, 2, [](const SweepRun& run) {
      return IsRight(run) ? run.delay_s : std::optional<double>();
    }));
    number(MeanText(row, 1, ErrorPercent));
  }
  return figure;
}

core::Result<Figure> MakeSweptFigure(std::vector<SweptRecord> records,
                                     const FigureContext& context) {
  LAB_CHECK(!records.empty() && records.size() <= kSweptMax, records.size());
  std::ranges::stable_sort(records, {}, [](const SweptRecord& record) {
    return record.fault ? record.fault->value : -1.0;  // healthy ones first
  });
  const auto faulty = std::ranges::find_if(
      records, [](const SweptRecord& record) { return record.fault.has_value(); });
  const double usual_s = faulty != records.end() ? faulty->fault->at_s : 0.0;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::pair<double, double> range{kFar, -kFar};
  const auto trace_of = [&](const SweptRecord& record) {
    SweepRun run;
    if (record.fault) {
      run.component = record.fault->component;
      run.value = record.fault->value;
    }
    OverlayTrace trace{LabelOf(run, true), {}, {}};
    const double zero_s = record.fault ? record.fault->at_s : usual_s;
    for (const core::Sample& sample : record.samples) {
      const double t_s = sample.t_s - zero_s;
      if (t_s < -kSweptBeforeS || t_s > kSweptAfterS) continue;
      const double y = core::ReadingOf(sample, record.channel);
      if (std::isfinite(y)) range = {std::min(range.first, t_s), std::max(range.second, t_s)};
      trace.t_s.push_back(t_s);
      trace.y.push_back(y);
    }
    return trace;
  };
  std::vector<OverlayPanel> panels;
  std::vector<OverlayTrace> healthy;  // in each panel
  for (const SweptRecord& record : records) {
    if (!record.fault) {
      healthy.push_back(trace_of(record));
      continue;
    }
    const std::string title = ComponentLabel(record.fault->component);
    auto panel = std::ranges::find_if(panels, [&](const OverlayPanel& each) {
      return each.title == title && each.channel == record.channel;
    });
    if (panel == panels.end()) {
      panels.push_back({title, healthy, record.channel});
      panel = panels.end() - 1;
    }
    panel->traces.push_back(trace_of(record));
  }
  if (panels.empty()) panels.push_back({"", healthy, records.front().channel});
  if (!(range.first < range.second)) return core::Refuse("figure_needs_samples", "recordings");
  Figure figure = MakeOverlayFigure(panels, context);
  figure.x.range = range;
  if (faulty != records.end()) figure.x.label = "Time since the change";
  return figure;
}

}  // namespace faultlab::server
