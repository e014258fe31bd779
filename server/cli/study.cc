#include "server/cli/study.h"

#include <algorithm>
#include <boost/json/serialize.hpp>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "core/diagnosis/diagnose_record.h"
#include "core/paper/window_study.h"
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

/// When the rig changed, in order.
std::vector<double> ChangesOf(const CsvRecord& record,
                              const core::Diagnosis& diagnosis,
                              const core::Bench& bench) {
  std::vector<double> changes_s;
  for (const core::Fault& fault : FaultsInComments(record.comments, bench)) {
    changes_s.push_back(fault.at_s);
    if (fault.until_s > fault.at_s) changes_s.push_back(fault.until_s);
  }
  std::ranges::sort(changes_s);
  if (changes_s.empty() && diagnosis.verdict.onset_s) changes_s = {*diagnosis.verdict.onset_s};
  return changes_s;
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
    for (std::size_t k = 0; k < row.estimates.size(); ++k) {
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
    if (!swa && !options.asked.exact) {
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
  if (options.asked.orders != "1" || options.asked.affine) {
    return Error{ErrorCode::kInvalid,
                 "--plots draws b0, b1, a1 of order 1 without a constant; leave out --order and "
                 "--affine",
                 "plots"};
  }
  const auto count = [](const std::string& list) { return 1 + std::ranges::count(list, ','); };
  if (std::max(count(options.asked.windows), count(options.asked.integrals)) >
      static_cast<std::ptrdiff_t>(kEstimateCurvesMax)) {
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
  StudiedRecord studied{
      record.samples, bench, record.period_s, delta_s, ChangesOf(record, diagnosis, bench)};
  if (!options.plots_dir.empty()) studied.curves = core::Curves::kKept;
  const auto study = StudyRecord(options.asked, studied);
  if (!study) {
    const std::string& field = study.error().field;
    const bool of_record = study.error().reason == "study_no_room";
    const std::string flag = field == "from_s" ? "--from" : "--" + field;
    PrintError((of_record ? options.recording : flag) + ": " + study.error().message);
    return kExitBadInput;
  }
  std::string text = StudyText(study.value(), options.recording);
  if (options.json) {
    boost::json::object out = ToJson(study.value());
    out["file"] = options.recording;
    text = boost::json::serialize(out) + "\n";
  }
  const int printed = Print(text);
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
  return Ended(Draw(options, study.value().rows, record.samples, std::move(context)));
}

}  // namespace faultlab::server
