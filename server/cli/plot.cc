#include "server/cli/plot.h"

#include <utility>

#include "hardware/bench/benches.h"
#include "server/cli/console.h"
#include "server/cli/figure_file.h"
#include "server/cli/recording_source.h"
#include "server/diagnosis_json/calibration_json.h"
#include "server/plots/record_figure.h"
#include "server/plots/sweep_figure.h"

namespace faultlab::server {

namespace {

/// Ends the command: a scale that is none is the caller's.
int WriteTo(const PlotOptions& options, const Figure& figure) {
  const core::Status written = WriteFigure(figure, options.output, options.scale);
  if (written) {
    return kExitOk;
  }
  const bool theirs = written.error().code == core::ErrorCode::kInvalid;  // scale
  return Fail(written.error(), theirs ? kExitBadInput : kExitFailure);
}

int PlotCurves(const PlotOptions& options, const core::Bench& bench) {
  if (options.recordings.size() > kSweptMax) {
    PrintError("--figure curves draws at most " + std::to_string(kSweptMax) + " recordings");
    return kExitBadInput;
  }
  std::vector<SweptRecord> records;
  for (const std::string& recording : options.recordings) {
    TRY_INPUT(auto source, LoadRecording(recording, options.data_dir, bench));
    TRY_INPUT_DONE(ParseFlags(options.flags, *source.bench));
    PrintNotes(source.notes);
    NoteOtherBench(recording, source.bench_named, options.flags.bench, *source.bench);
    SweptRecord& record = records.emplace_back();
    if (!source.faults.empty()) record.fault = source.faults.front();
    record.channel = source.bench->structure->estimated;
    record.samples = std::move(source.samples);
  }
  FigureContext context;
  context.footer = "faultlab " + std::string(Version());
  TRY_INPUT(const auto figure, MakeSweptFigure(std::move(records), context));
  return WriteTo(options, figure);
}

}  // namespace

int RunPlot(const PlotOptions& options) {
  TRY_INPUT(const auto bench, hardware::LoadBench(options.flags.bench));
  if (options.figure == "curves") return PlotCurves(options, *bench);
  if (options.recordings.size() > 1) {
    PrintError("several recordings are drawn by --figure curves");
    return kExitBadInput;
  }
  const std::string& recording = options.recordings.front();
  TRY_INPUT(const auto source, LoadRecording(recording, options.data_dir, *bench));
  TRY_INPUT(auto diagnose, ParseFlags(options.flags, *source.bench));
  PrintNotes(source.notes);
  NoteOtherBench(recording, source.bench_named, options.flags.bench, *source.bench);
  FollowRecord(options.flags, source.samples, source.period_s, diagnose);
  TRY_INPUT_DONE(CheckPeriod(diagnose.calibration, diagnose.period_s));
  FigureContext context;
  context.name = source.name;
  context.footer = "faultlab " + std::string(Version());
  context.faults = source.faults;
  TRY_INPUT(const auto figure,
            MakeFigure(options.figure, source.samples, diagnose, std::move(context)));
  return WriteTo(options, figure);
}

}  // namespace faultlab::server
