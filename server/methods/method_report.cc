#include "server/methods/method_report.h"

#include <boost/json/array.hpp>
#include <cmath>

#include "core/types/number_text.h"
#include "server/json/number_or_null.h"
#include "server/plots/value_text.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Format;
using core::Interval;

std::string Share(int hits, int all) {
  if (all == 0) return "-";
  const Interval interval = core::WilsonInterval(hits, all);
  return Format("%d/%d (%.0f-%.0f %%)", hits, all, 100.0 * interval.low, 100.0 * interval.high);
}

std::string Percent(double ratio) {
  return std::isfinite(ratio) ? Format("%.2g %%", 100.0 * ratio) : std::string("-");
}

/// 95 %, of a median, by order statistics.
Interval MedianInterval(const std::vector<double>& values) {
  const double half = 0.98 / std::sqrt(static_cast<double>(values.size()));
  return {core::Quantile(values, std::max(0.0, 0.5 - half)),
          core::Quantile(values, std::min(1.0, 0.5 + half))};
}

std::string Error(const MethodRow& row) {
  if (!row.info->identifies) return "cannot";
  if (row.errors.empty()) return "-";
  const Interval interval = MedianInterval(row.errors);
  return Percent(core::Quantile(row.errors, 0.5)) + " (" + Percent(interval.low) + " - " +
         Percent(interval.high) + ")";
}

std::string Delay(const MethodRow& row) {
  if (row.delays.empty()) return "-";
  return Format("%.0f / %.0f", core::Quantile(row.delays, 0.5), core::Quantile(row.delays, 0.95));
}

std::string FalseAlarms(const MethodRow& row) {
  if (row.watched_days <= 0.0) return "-";
  const Interval interval = core::PoissonInterval(row.false_alarms);
  return Format("%.2g (%.2g-%.2g)",
                row.false_alarms / row.watched_days,
                interval.low / row.watched_days,
                interval.high / row.watched_days);
}

std::string Transient(const MethodRow& row) {
  if (row.faulty == 0) return "-";
  std::string text;
  for (std::size_t i = 0; i < row.isolated.size(); ++i) {
    text += (i > 0 ? " " : "") +
            Format("%.0f", 100.0 * row.isolated[i] / static_cast<double>(row.faulty));
  }
  return text;
}

std::string InTime(const MethodRow& row, double period_s) {
  if (row.info->pace == core::MethodPace::kAfterwards) return "no, search after the alarm";
  if (!row.in_time(period_s)) return "no";
  return row.info->pace == core::MethodPace::kBlocks ? "yes, by blocks" : "yes";
}

/// "-" where there was none.
std::string Time(const std::vector<double>& times) {
  return times.empty() ? std::string("-") : Format("%.2g", core::Quantile(times, 0.5));
}

std::string Memory(std::size_t bytes) {
  return bytes < 10'240 ? Format("%zu B", bytes)
                        : Format("%.0f kB", static_cast<double>(bytes) / 1024.0);
}

std::string FaultName(const core::FaultSize& fault) {
  return std::string(core::Name(fault.component)) + " = " +
         PlainText(ValueText(fault.value, core::Unit(fault.component)));
}

json::array ToJson(const Interval& interval, double scale) {
  return {interval.low * scale, interval.high * scale};
}

const char* ChannelsText(const MethodStudy& study) {
  const core::Channels channels = TaskOptions(study.options, study.period_s).channels;
  return channels == core::Channels::kAll ? "all" : "um";
}

/// What the method said at the end of this record.
json::object ToJson(const MethodOutcome& outcome) {
  const core::MethodFinding& finding = outcome.finding;
  json::value fault;
  if (outcome.fault) {
    fault = json::object{{"component", core::Name(outcome.fault->component)},
                         {"value", outcome.fault->value},
                         {"at_s", outcome.fault->at_s}};
  }
  const core::MethodInfo& info = *core::FindMethod(outcome.method);
  json::array cannot;
  if (!outcome.refused.empty()) cannot.emplace_back("calibrate: " + outcome.refused);
  if (!info.isolates) cannot.emplace_back("isolate");
  if (!info.identifies) cannot.emplace_back("identify");
  json::value component;
  json::value value;
  if (finding.isolation == core::Answer::kGiven && finding.named > 0) {
    component = core::Name(finding.candidates.front().component);
    if (finding.identification == core::Answer::kGiven) {
      value = NumberOrNull(finding.candidates.front().value);
    }
  }
  return {{"method", outcome.method},
          {"file", outcome.record},
          {"fault", std::move(fault)},
          {"detected_at_s", outcome.alarmed_at_s ? json::value(*outcome.alarmed_at_s) : nullptr},
          {"component", std::move(component)},
          {"value", std::move(value)},
          {"cannot", std::move(cannot)}};
}

json::object ToJson(const MethodRow& row, const MethodStudy& study) {
  const core::MethodInfo& info = *row.info;
  json::object intervals = {
      {"detected", ToJson(core::WilsonInterval(row.detected, row.faulty), 1.0)},
      {"isolated", ToJson(core::WilsonInterval(row.isolated.back(), row.faulty), 1.0)}};
  json::value false_alarms;
  if (row.watched_days > 0.0) {
    false_alarms = row.false_alarms / row.watched_days;
    intervals["false_alarms_per_day"] =
        ToJson(core::PoissonInterval(row.false_alarms), 1.0 / row.watched_days);
  }
  if (!row.errors.empty()) {
    intervals["error_median_percent"] = ToJson(MedianInterval(row.errors), 100.0);
  }
  json::array by_fault;
  for (std::size_t f = 0; f < row.isolated_of.size(); ++f) {
    by_fault.emplace_back(
        json::object{{"component", core::Name(study.faults[f].component)},
                     {"value", study.faults[f].value},
                     {"detected", row.detected_of[f]},
                     {"delay_samples_median", NumberOrNull(row.delay_of[f])},
                     {"isolated", row.isolated_of[f]},
                     {"error_median_percent", NumberOrNull(100.0 * row.error_of[f])}});
  }
  const bool runs = row.fits;
  return {{"method", info.name},
          {"title", info.title},
          {"group", info.group},
          {"fits", row.fits},
          {"real_time", runs ? json::value(row.in_time(study.period_s)) : nullptr},
          {"delay_samples_median", NumberOrNull(core::Quantile(row.delays, 0.5))},
          {"false_alarms_per_day", std::move(false_alarms)},
          {"false_alarms", row.false_alarms},
          {"watched_days", row.watched_days},
          {"of", row.faulty},
          {"refused", row.refused},
          {"detected", row.detected},
          {"isolated", info.isolates ? json::value(row.isolated.back()) : nullptr},
          {"isolated_after", ListOf(row.isolated)},
          {"error_median_percent", NumberOrNull(100.0 * core::Quantile(row.errors, 0.5))},
          {"ns_per_sample", NumberOrNull(1000.0 * core::Quantile(row.sample_us, 0.5))},
          {"ms_per_diagnosis", NumberOrNull(core::Quantile(row.diagnosis_ms, 0.5))},
          {"memory_bytes", row.bytes > 0 ? json::value(row.bytes) : nullptr},
          {"interval_95", std::move(intervals)},
          {"tuned", info.tuned},
          {"tuning", info.tuning},
          {"level", info.LevelFor(TaskOptions(study.options, study.period_s).channels)},
          {"faults", std::move(by_fault)}};
}

}  // namespace

std::string ToText(const MethodStudy& study) {
  std::string text = Format("%-12s %-20s %-10s %-16s %-20s %-30s %9s %9s\n",
                            "method",
                            "detected",
                            "delay",
                            "false alarms/day",
                            "isolated at the end",
                            "error, median",
                            "us/sample",
                            "ms/diag.");
  for (const MethodRow& row : study.rows) {
    if (!row.fits) {
      text += Format("%-12s made for another bench\n", std::string(row.info->name).c_str());
      continue;
    }
    text += Format("%-12s %-20s %-10s %-16s %-20s %-30s %9s %9s\n",
                   std::string(row.info->name).c_str(),
                   Share(row.detected, row.faulty).c_str(),
                   Delay(row).c_str(),
                   FalseAlarms(row).c_str(),
                   Share(row.isolated.back(), row.faulty).c_str(),
                   Error(row).c_str(),
                   Time(row.sample_us).c_str(),
                   Time(row.diagnosis_ms).c_str());
  }
  return text;
}

std::string MarkdownTitle() {
  return "# The methods of Table 21, measured\n\nWritten by `faultlab methods --markdown`; how, "
         "and "
         "what the figures say about the paper's words:\n[methods/README.md](methods/README.md). "
         "Shares with Wilson's 95 % interval, false alarms with Poisson's, medians by order "
         "statistics.\n\n";
}

std::string ToMarkdown(const MethodStudy& study) {
  const std::string source =
      study.recordings > 0
          ? Format("%d given recordings", study.recordings)
          : Format("%zu faults x %d seeds (from %llu) and %.3g h of healthy runs a method",
                   study.faults.size(),
                   study.options.trials,
                   static_cast<unsigned long long>(study.options.seed),
                   study.options.healthy_hours);
  std::string out = "## " + study.options.bench->name + ", channels " + ChannelsText(study) + ": " +
                    source + "\n\n";
  out +=
      "| method | the paper's Table 21, in other words | real time | detected | delay, median / "
      "95 % (samples) | false alarms a day | isolated at the end | isolated 0.2, 0.5, 1, 5 s after "
      "the alarm, at the end (%) | error of the value, median | us a sample | ms a diagnosis | "
      "memory | tuning |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const MethodRow& row : study.rows) {
    const core::MethodInfo& info = *row.info;
    out += "| " + std::string(info.title) + " (`" + std::string(info.name) + "`) | " +
           std::string(info.paper.empty() ? "no row" : info.paper) + " | ";
    if (!row.fits) {
      out += "made for another bench | - | - | - | - | - | - | - | - | - | - |\n";
      continue;
    }
    out += InTime(row, study.period_s) + " | " + Share(row.detected, row.faulty) + " | " +
           Delay(row) + " | " + FalseAlarms(row) + " | " +
           (info.isolates ? Share(row.isolated.back(), row.faulty) : "cannot") + " | " +
           Transient(row) + " | " + Error(row) + " | " + Time(row.sample_us) + " | " +
           Time(row.diagnosis_ms) + " | " + Memory(row.bytes) + " | " + std::string(info.tuned) +
           (info.tunings.size() > 1 ? Format(" %g", info.tuning) : "") + " |\n";
  }
  if (study.recordings > 0) return out;
  out += "\nBy fault: isolated at the end of " + std::to_string(study.options.trials) +
         ", median error of the value (%):\n\n| fault |";
  for (const MethodRow& row : study.rows) out += " " + std::string(row.info->name) + " |";
  out += "\n|---|";
  for (std::size_t m = 0; m < study.rows.size(); ++m) out += "---|";
  for (std::size_t f = 0; f < study.faults.size(); ++f) {
    out += "\n| " + FaultName(study.faults[f]) + " |";
    for (const MethodRow& row : study.rows) {
      if (!row.fits || f >= row.isolated_of.size()) {
        out += " - |";
        continue;
      }
      out += Format(" %d", row.isolated_of[f]);
      if (row.detected_of[f] < study.records_of[f]) {
        out += Format(" [%d]", row.detected_of[f]);
      }
      if (std::isfinite(row.error_of[f])) out += Format(", %.2g", 100.0 * row.error_of[f]);
      out += " |";
    }
  }
  return out + "\n\n`[n]`: only n of them were detected.\n";
}

json::object ToJson(const MethodStudy& study) {
  const auto outcome_to_json = [](const MethodOutcome& outcome) { return ToJson(outcome); };
  const auto row_to_json = [&](const MethodRow& row) { return ToJson(row, study); };
  return {{"bench", study.options.bench->name},
          {"channels", ChannelsText(study)},
          {"trials", study.options.trials},
          {"healthy_hours", study.options.healthy_hours},
          {"seed", study.options.seed},
          {"recordings", study.recordings},
          {"period_s", study.period_s},
          {"isolated_after_s", ListOf(core::kLookAfterS)},
          {"records", ListOf(study.outcomes, outcome_to_json)},
          {"methods", ListOf(study.rows, row_to_json)}};
}

Figure MakeMethodFigure(const MethodStudy& study) {
  Figure figure;
  figure.title = "Methods and faults: isolated at the end, median error of the value";
  const auto [least, most] = std::ranges::minmax(study.records_of);
  figure.subtitle = study.options.bench->name +
                    (least == most ? Format(", %d record%s a fault", most, most == 1 ? "" : "s")
                                   : Format(", %d to %d records a fault", least, most));
  figure.matrix.row_title = "Method";
  figure.matrix.column_title = "Fault";
  for (const core::FaultSize& fault : study.faults) {
    figure.matrix.columns.push_back(ComponentLabel(fault.component) + " " +
                                    ValueText(fault.value, core::Unit(fault.component)));
  }
  for (const MethodRow& row : study.rows) {
    if (!row.fits || row.isolated_of.size() != study.faults.size()) continue;
    figure.matrix.rows.push_back(std::string(row.info->name));
    for (std::size_t f = 0; f < study.faults.size(); ++f) {
      const int records = study.records_of[f];
      const double share = static_cast<double>(row.isolated_of[f]) / std::max(1, records);
      figure.matrix.value.push_back(share);
      figure.matrix.text.push_back(std::isfinite(row.error_of[f]) && share > 0.0
                                       ? Format("%.2g %%", 100.0 * row.error_of[f])
                                       : Format("%d/%d", row.isolated_of[f], records));
    }
  }
  figure.footer = "full colour: every record isolated; text: median error, or how many";
  return figure;
}

}  // namespace faultlab::server
