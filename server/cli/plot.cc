#include "server/cli/plot.h"

#include <utility>

#include "hardware/bench/benches.h"
#include "server/cli/console.h"
#include "server/cli/figure_file.h"
#include "server/cli/recording_source.h"
#include "server/diagnosis_json/calibration_json.h"
#include "server/plots/record_figure.h"

namespace faultlab::server {

int RunPlot(const PlotOptions& options) {
  TRY_INPUT(const auto bench, hardware::LoadBench(options.flags.bench));
  TRY_INPUT(const auto source, LoadRecording(options.recording, options.data_dir, *bench));
  TRY_INPUT(auto diagnose, ParseFlags(options.flags, *source.bench));
  PrintNotes(source.notes);
  NoteOtherBench(options.recording, source.bench_named, options.flags.bench, *source.bench);
  FollowRecord(options.flags, source.samples, source.period_s, diagnose);
  TRY_INPUT_DONE(CheckPeriod(diagnose.calibration, diagnose.period_s));
  FigureContext context;
  context.name = source.name;
  context.footer = "faultlab " + std::string(Version());
  context.faults = source.faults;
  TRY_INPUT(const auto figure,
            MakeFigure(options.figure, source.samples, diagnose, std::move(context)));
  const core::Status written = WriteFigure(figure, options.output, options.scale);
  if (written) {
    return kExitOk;
  }
  const bool theirs = written.error().code == core::ErrorCode::kInvalid;  // scale
  return Fail(written.error(), theirs ? kExitBadInput : kExitFailure);
}

}  // namespace faultlab::server
