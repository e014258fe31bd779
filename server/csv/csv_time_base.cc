#include "server/csv/csv_time_base.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "core/types/number_text.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;

/// How late a sample of a paced loop may be and still belong to its tick: just under half a period.
constexpr double kGridTolerance = 0.45;
/// A step belongs to another time base if it differs from the median by more than this ..
constexpr double kStepTolerance = 0.25;
/// .. and so do the next ones in the same way: this many in a row are not lost rows.
constexpr std::size_t kSameStepsMax = 10;
constexpr double kAlike = 0.05;
/// Steps that are no whole multiple of the period, in number and in share: more are not of a few
/// rows.
constexpr std::size_t kUnevenSteps = 4;
constexpr double kUnevenShare = 0.1;
/// Above it no model of the bench applies: the unit of the time is wrong.
constexpr double kPeriodMax_s = 1.0;
/// Below it no converter reads: it is in days, or in a unit that is too large.
constexpr double kPeriodMin_s = 2e-6;
constexpr std::size_t kGapNotesMax = 3;
constexpr double kMicrosecondsPerSecond = 1e6;

std::string Seconds(double value) {
  return core::Format("%.9g s", value);
}

/// The unit in which the steps would be those of a usual record.
std::string AdviceOnUnit(double step_s) {
  struct Scale {
    double factor;
    const char* advice;
  };
  constexpr std::array<Scale, 4> kScales = {
      {{1e-3, "; if the time is in milliseconds, name the column t_ms"},
       {1e-6, "; if the time is in microseconds, name the column t_us"},
       {1e-9, "; if the time is in nanoseconds, name the column t_ns"},
       {86'400.0, "; if the time is in days, as of a spreadsheet, multiply it by 86400"}}};
  constexpr double kUsualLeast_s = 1e-4;
  constexpr double kUsualMost_s = 0.1;
  for (const Scale& each : kScales) {
    const double scaled = step_s * each.factor;
    if (scaled >= kUsualLeast_s && scaled <= kUsualMost_s) return each.advice;
  }
  return "; look at the unit of the time";
}

double MedianStep(std::span<const core::Sample> samples) {
  std::vector<double> steps;
  steps.reserve(samples.size() - 1);
  for (std::size_t row = 1; row < samples.size(); ++row) {
    steps.push_back(samples[row].t_s - samples[row - 1].t_s);
  }
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

/// First row of a stretch whose steps agree with each other but not with `period`.
std::optional<std::size_t> OtherTimeBase(std::span<const core::Sample> samples, double period) {
  std::size_t same = 0;
  double previous = period;
  for (std::size_t row = 1; row < samples.size(); ++row) {
    const double step = samples[row].t_s - samples[row - 1].t_s;
    const bool foreign = std::abs(step - period) > kStepTolerance * period;
    const bool alike = same > 0 && std::abs(step - previous) <= kAlike * previous;
    same = !foreign ? 0 : alike ? same + 1 : 1;
    previous = step;
    if (same == kSameStepsMax) {
      return row + 1 - kSameStepsMax;
    }
  }
  return std::nullopt;
}

/// Whether more steps are no whole multiple of the period than a few late rows make.
bool IsUneven(std::span<const core::Sample> samples, double period) {
  std::size_t off = 0;
  for (std::size_t row = 1; row < samples.size(); ++row) {
    const double steps = (samples[row].t_s - samples[row - 1].t_s) / period;
    if (std::abs(steps - std::max(1.0, std::round(steps))) > kStepTolerance) ++off;
  }
  return off > kUnevenSteps &&
         static_cast<double>(off) > kUnevenShare * static_cast<double>(samples.size());
}

double RefinePeriod(std::span<const core::Sample> samples, double median) {
  // A late row makes a long step and a short one, so the rounding remainder of a step is passed on
  // to the next. It is reduced each time, because the median itself has a small error that would
  // add up.
  constexpr double kFade = 0.5;
  double periods = 0.0;
  double left_over = 0.0;
  for (std::size_t row = 1; row < samples.size(); ++row) {
    const double steps = (samples[row].t_s - samples[row - 1].t_s) / median + kFade * left_over;
    const double whole = std::round(steps);
    left_over = steps - whole;
    periods += whole;
  }
  periods = std::max(1.0, periods);
  const double refined = (samples.back().t_s - samples.front().t_s) / periods;
  const double round = std::round(refined * kMicrosecondsPerSecond) / kMicrosecondsPerSecond;
  constexpr double kEndAgreement = 0.1;  // periods by which the rounded grid may miss the last row
  return round > 0.0 && std::abs(round - refined) * periods < kEndAgreement * refined ? round
                                                                                      : refined;
}

/// Steps from one gap to the next, if all are the same but for one: lost rows do not come at a
/// beat, times that were rounded do. 0: there is no beat.
std::size_t BeatOf(std::span<const std::size_t> gap_rows) {
  constexpr std::size_t kGapsMin = 8;
  constexpr std::size_t kBeatMax = 20;  // a logger that stops now and then has a longer one
  constexpr double kShare = 0.95;
  if (gap_rows.size() < kGapsMin) return 0;
  std::vector<std::size_t> apart;
  for (std::size_t i = 1; i < gap_rows.size(); ++i) apart.push_back(gap_rows[i] - gap_rows[i - 1]);
  const auto middle = apart.begin() + static_cast<std::ptrdiff_t>(apart.size() / 2);
  std::nth_element(apart.begin(), middle, apart.end());
  const std::size_t beat = *middle;
  const auto on_beat = std::ranges::count_if(
      apart, [&](std::size_t rows) { return rows + 1 >= beat && rows <= beat + 1; });
  const bool regular = static_cast<double>(on_beat) >= kShare * static_cast<double>(apart.size());
  return regular && beat > 1 && beat <= kBeatMax ? beat : 0;
}

}  // namespace

Error CsvError(std::string_view name,
               std::uint32_t line,
               std::string_view column,
               std::string reason,
               const std::string& message) {
  const std::string where = std::string(name) + ":" + std::to_string(line) + ": ";
  const std::string what = column.empty() ? "" : "column " + std::string(column) + ": ";
  return {ErrorCode::kInvalid,
          where + what + message,
          std::string(column),
          std::move(reason),
          {{"line", std::to_string(line)}, {"column", std::string(column)}}};
}

void CountFromFirstRow(std::vector<core::Sample>& samples) {
  constexpr double kDay_s = 86'400.0;
  constexpr double kAtMidnight_s = 3'600.0;  // what goes back by less than a day is a reset
  if (samples.empty()) return;
  const double first_s = samples.front().t_s;
  double last_s = 0.0;
  for (core::Sample& sample : samples) {
    sample.t_s -= first_s;
    const bool other_day = last_s < kDay_s && sample.t_s < last_s - kDay_s + kAtMidnight_s;
    if (other_day) sample.t_s += kDay_s;
    last_s = sample.t_s;
  }
}

std::string LeaveOutBeforeRestart(std::vector<core::Sample>& samples,
                                  std::vector<std::uint32_t>& line_of) {
  constexpr std::size_t kRowsMost = 10;
  constexpr std::size_t kTimesAsManyAfter = 10;
  const auto back = std::ranges::adjacent_find(
      samples, [](const auto& row, const auto& next) { return next.t_s < row.t_s; });
  // Later than the first one it is a row in the wrong place.
  if (back == samples.end() || std::next(back)->t_s > samples.front().t_s) return "";
  const auto rows = back - samples.begin() + 1;
  const auto left_out = static_cast<std::size_t>(rows);
  if (left_out > kRowsMost || samples.size() < (1 + kTimesAsManyAfter) * left_out) return "";
  samples.erase(samples.begin(), samples.begin() + rows);
  line_of.erase(line_of.begin(), line_of.begin() + rows);
  return "the time begins again in line " + std::to_string(line_of.front()) + ": " +
         std::to_string(left_out) + (left_out == 1 ? " row" : " rows") + " before it left out";
}

std::optional<Error> AssignTimeBase(CsvRecord& record,
                                    std::span<const std::uint32_t> line_of,
                                    std::string_view name) {
  std::vector<core::Sample>& samples = record.samples;
  LAB_CHECK(samples.size() >= 2 && line_of.size() == samples.size());
  const auto fail = [&](std::size_t row, std::string reason, const std::string& message) {
    return CsvError(name, line_of[row], "t_s", std::move(reason), message);
  };
  for (std::size_t row = 1; row < samples.size(); ++row) {
    const double before = samples[row - 1].t_s;
    if (!(samples[row].t_s > before)) {
      const bool same = samples[row].t_s == before;
      return fail(row,
                  "csv_time_back",
                  std::string("time ") + (same ? "repeats " : "goes back from ") + Seconds(before) +
                      (same ? "" : " to " + Seconds(samples[row].t_s)) +
                      ", expected it to rise by one period in each row");
    }
  }
  const double median = MedianStep(samples);
  if (const std::optional<std::size_t> row = OtherTimeBase(samples, median)) {
    return fail(*row,
                "csv_two_time_bases",
                "two time bases: the step is " +
                    Seconds(samples[*row].t_s - samples[*row - 1].t_s) +
                    " from here on, expected " + Seconds(median) + " as in most of the file");
  }
  if (median >= kPeriodMax_s || median < kPeriodMin_s) {
    return fail(1,
                "csv_rows_far_apart",
                "the rows are " + Seconds(median) +
                    (median < kPeriodMin_s ? " apart, too near" : " apart, too far") +
                    " for a motor that settles in 0.1 s" + AdviceOnUnit(median));
  }
  record.period_s = RefinePeriod(samples, median);
  const bool uneven = IsUneven(samples, record.period_s);
  const double start = samples.front().t_s;
  std::vector<std::size_t> gap_rows;
  for (std::size_t row = 1; row < samples.size(); ++row) {
    const double place = (samples[row].t_s - start) / record.period_s;
    const double step = samples[row].t_s - samples[row - 1].t_s;
    const std::int64_t before = samples[row - 1].index;
    const double index = std::round(place);
    if (std::abs(place - index) > kGridTolerance || index <= static_cast<double>(before)) {
      if (std::abs(step - record.period_s) <= kStepTolerance * record.period_s) {
        return fail(row,
                    "csv_steps_uneven",
                    "the steps add up to " + Seconds(samples[row].t_s - start) + ", at " +
                        Seconds(record.period_s) + " a row " +
                        Seconds(record.period_s * static_cast<double>(before + 1)) +
                        " are expected, and the sum may be off by 0.45 of a row: the rows are not "
                        "evenly spaced, bring them to one period first");
      }
      return fail(row,
                  "csv_step_wrong",
                  "step of " + Seconds(step) + ", expected " + Seconds(record.period_s) +
                      " or a whole multiple where rows are missing" +
                      (uneven ? "; the rows are not evenly spaced: bring them to one period first, "
                                "or record them at one"
                              : ""));
    }
    if (index - static_cast<double>(row) > static_cast<double>(samples.size())) {
      return fail(row,
                  "csv_time_jumps",
                  "time jumps by " + Seconds(step) + ": more rows missing than present, expected " +
                      Seconds(record.period_s) + " between rows");
    }
    samples[row].index = static_cast<std::int64_t>(index);
    const std::int64_t missing = samples[row].index - before - 1;
    if (missing > 0) gap_rows.push_back(row);
    if (missing > 0 && gap_rows.size() <= kGapNotesMax) {
      record.notes.push_back(std::string(name) + ":" + std::to_string(line_of[row]) + ": " +
                             std::to_string(missing) + " rows missing before this line");
    }
    record.missing_samples += missing;
  }
  if (const std::size_t beat = BeatOf(gap_rows); beat > 0) {
    const double mean_s = (samples.back().t_s - start) / static_cast<double>(samples.size() - 1);
    return fail(gap_rows[1],
                "csv_gaps_at_a_beat",
                "about every " + std::to_string(beat) +
                    " rows a step is longer: lost rows do not come at a beat. If the times are "
                    "rounded, write them with more digits; rows of even spacing are " +
                    Seconds(mean_s) + " apart");
  }
  if (gap_rows.size() > kGapNotesMax) {
    record.notes.push_back(std::string(name) + ": " + std::to_string(gap_rows.size()) +
                           " gaps in all, " + std::to_string(record.missing_samples) +
                           " rows missing");
  }
  return std::nullopt;
}

}  // namespace faultlab::server
