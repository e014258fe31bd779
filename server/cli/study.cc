#include "server/cli/study.h"

#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/serialize.hpp>
#include <charconv>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/diagnosis/diagnose_record.h"
#include "core/paper/window_study.h"
#include "core/types/number_text.h"
#include "hardware/bench/benches.h"
#include "server/cli/console.h"
#include "server/cli/figure_file.h"
#include "server/cli/study_text.h"
#include "server/csv/bench_comment.h"
#include "server/csv/csv_record.h"
#include "server/csv/fault_text.h"
#include "server/plots/record_figure.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;
using core::Result;
using core::VariantSpec;

std::vector<std::string_view> Split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(separator), text.size());
    parts.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return parts;
}

std::optional<int> ParseCount(std::string_view text) {
  int value = 0;
  const std::from_chars_result read =
      std::from_chars(text.data(), text.data() + text.size(), value);
  return read.ec == std::errc() && read.ptr == text.data() + text.size() && value > 0
             ? std::optional(value)
             : std::nullopt;
}

Result<std::vector<VariantSpec>> ParseVariants(const StudyCommandOptions& options,
                                               core::EstimatedChannel channel,
                                               double period_s,
                                               double delta_s) {
  VariantSpec spec;
  spec.channel = channel;
  spec.order = options.order;
  spec.affine = options.affine;
  spec.period_s = period_s;
  std::vector<VariantSpec> variants;
  for (const std::string_view part : Split(options.windows, ',')) {
    const std::optional<int> window = ParseCount(part);
    if (!window) {
      return Error{ErrorCode::kInvalid,
                   "--k '" + options.windows + "': expected windows K such as 50,100,200",
                   "k"};
    }
    spec.window_samples = *window;
    variants.push_back(spec);
  }
  spec.method = core::EstimatorMethod::kSia;
  spec.sia_mode = options.exact ? core::SiaMode::kExact : core::SiaMode::kPaper;
  spec.delta_s = options.exact ? delta_s : 0.0;
  for (const std::string_view part : Split(options.integrals, ',')) {
    const std::size_t colon = std::min(part.find(':'), part.size());
    const std::optional<int> window = ParseCount(part.substr(0, colon));
    const std::optional<int> integral = ParseCount(part.substr(std::min(colon + 1, part.size())));
    if (!window || !integral) {
      return Error{ErrorCode::kInvalid,
                   "--km '" + options.integrals + "': expected pairs K:m such as 20:5,100:20",
                   "km"};
    }
    spec.window_samples = *window;
    spec.integral_samples = *integral;
    variants.push_back(spec);
  }
  if (variants.empty()) {
    return Error{ErrorCode::kInvalid, "no window to study; give --k or --km", "k"};
  }
  return variants;
}

/// Time of the change, if the record has one.
Result<std::optional<double>> ChangeOf(const StudyCommandOptions& options,
                                       const CsvRecord& record,
                                       const core::Diagnosis& diagnosis,
                                       const core::Bench& bench) {
  if (options.change == "none") {
    return std::optional<double>();
  }
  if (options.change == "auto") {
    const std::vector<core::Fault> faults = FaultsInComments(record.comments, bench);
    return faults.empty() ? diagnosis.verdict.onset_s : std::optional(faults.front().at_s);
  }
  const std::optional<double> at_s = core::ParseNumber(options.change);
  if (!at_s) {
    return Error{ErrorCode::kInvalid,
                 "--change '" + options.change + "': expected auto, none or a time in seconds",
                 "change"};
  }
  return at_s;
}

std::size_t IndexAt(const std::vector<core::Sample>& samples, double t_s) {
  const auto at = std::ranges::lower_bound(samples, t_s, {}, &core::Sample::t_s);
  return static_cast<std::size_t>(at - samples.begin());
}

std::vector<EstimateCurve> CurvesOf(const std::vector<core::WindowStudyRow>& rows,
                                    core::EstimatorMethod method,
                                    const std::vector<core::Sample>& samples) {
  std::vector<EstimateCurve> curves;
  for (const core::WindowStudyRow& row : rows) {
    if (row.spec.method != method) {
      continue;
    }
    EstimateCurve& curve = curves.emplace_back();
    curve.name = WindowName(row.spec.window_samples, row.spec.integral_samples);
    curve.settling_samples = row.transient_samples;
    for (std::size_t k = 0; k < samples.size(); ++k) {
      const core::VariantEstimate& estimate = row.estimates[k];
      curve.t_s.push_back(samples[k].t_s);
      for (int parameter = 0; parameter < 3; ++parameter) {
        const auto at = static_cast<std::size_t>(parameter);
        const bool drawn = IsDrawable(estimate.status,
                                      estimate.age_samples,
                                      {estimate.sigma[0], estimate.sigma[1], estimate.sigma[2]},
                                      parameter);
        curve.theta[at].push_back(drawn ? estimate.theta[at] : core::kAbsent);
      }
    }
  }
  return curves;
}

core::Status Draw(const StudyCommandOptions& options,
                  const std::vector<core::WindowStudyRow>& rows,
                  const std::vector<core::Sample>& samples,
                  FigureContext context) {
  std::error_code error;
  std::filesystem::create_directories(options.plots_dir, error);
  if (error) {
    return Error{ErrorCode::kUnavailable,
                 "cannot make the folder " + options.plots_dir + ": " + error.message(),
                 "plots"};
  }
  for (const bool swa : {true, false}) {
    const std::vector<EstimateCurve> curves =
        CurvesOf(rows, swa ? core::EstimatorMethod::kSwa : core::EstimatorMethod::kSia, samples);
    if (curves.empty()) {
      continue;
    }
    if (!swa && !options.exact) {
      context.nominal_sia.reset();  // the paper's rule gives b1 and a1 that are 30 % too high
    }
    const std::string name = swa ? "swa.png" : "sia.png";
    TRY_DONE(WriteFigure(
        MakeCurvesFigure(curves, swa ? EstimatorFamily::kSwa : EstimatorFamily::kSia, context),
        (std::filesystem::path(options.plots_dir) / name).string(),
        1));
  }
  return core::Done{};
}

core::Status CheckPlots(const StudyCommandOptions& options) {
  if (options.plots_dir.empty()) {
    return core::Done{};
  }
  if (options.order != 1 || options.affine) {
    return Error{ErrorCode::kInvalid,
                 "--plots draws b0, b1, a1 of order 1 without a constant; leave out --order and "
                 "--affine",
                 "plots"};
  }
  if (std::max(Split(options.windows, ',').size(), Split(options.integrals, ',').size()) >
      kEstimateCurvesMax) {
    return Error{ErrorCode::kInvalid,
                 "--plots tells at most " + std::to_string(kEstimateCurvesMax) +
                     " windows of --k or --km apart by colour",
                 "plots"};
  }
  return core::Done{};
}

}  // namespace

int RunStudy(const StudyCommandOptions& options) {
  TRY_INPUT_DONE(CheckPlots(options));
  TRY_INPUT(const auto loaded, hardware::LoadBench(options.bench));
  const core::Bench& bench = *loaded;
  TRY_INPUT(const auto record, ReadCsv(options.recording));
  PrintNotes(record.notes);
  NoteOtherBench(options.recording, BenchInComments(record.comments), options.bench, bench);
  core::DiagnosisOptions diagnose = core::OptionsOf(bench);
  diagnose.values = core::ValuePrior::kTable2;
  diagnose.period_s = record.period_s;
  const core::Diagnosis diagnosis = core::DiagnoseRecord(record.samples, diagnose);
  const double delta_s = diagnosis.calibration ? diagnosis.calibration->delta_s : 0.0;
  TRY_INPUT(const auto variants,
            ParseVariants(options, bench.structure->estimated, record.period_s, delta_s));
  TRY_INPUT(const auto change, ChangeOf(options, record, diagnosis, bench));
  const std::size_t at = change ? IndexAt(record.samples, *change) : record.samples.size();
  const Result<std::vector<core::WindowStudyRow>> rows =
      core::StudyWindows(record.samples, IndexAt(record.samples, options.from_s), at, variants);
  if (!rows) {
    PrintError(options.recording + ": " + rows.error().message);
    return kExitBadInput;
  }
  const StudySettings settings{
      options.recording, record.period_s, options.from_s, change, record.samples.size()};
  const int printed =
      Print(options.json ? boost::json::serialize(StudyJson(rows.value(), settings)) + "\n"
                         : StudyText(rows.value(), settings));
  if (printed != kExitOk || options.plots_dir.empty()) {
    return printed;
  }
  FigureContext context;
  context.name = std::filesystem::path(options.recording).filename().string();
  context.footer = "faultlab " + std::string(Version());
  context.faults = FaultsInComments(record.comments, bench);
  context.episodes = core::EpisodesOf(diagnosis);
  context.nominal_swa =
      diagnosis.nominal_estimates[static_cast<std::size_t>(core::EstimatorId::kSwa100)];
  context.nominal_sia =
      diagnosis.nominal_estimates[static_cast<std::size_t>(core::EstimatorId::kSia100x20)];
  return Ended(Draw(options, rows.value(), record.samples, std::move(context)));
}

}  // namespace faultlab::server
