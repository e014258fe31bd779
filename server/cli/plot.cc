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
  const core::Result<const core::Bench*> bench = hardware::LoadBench(options.flags.bench);
  if (!bench) {
    return Fail(bench.error(), kExitBadInput);
  }
  const core::Result<SourceRecording> source =
      LoadRecording(options.recording, options.data_dir, *bench.value());
  if (!source) {
    return Fail(source.error(), kExitBadInput);
  }
  core::Result<core::DiagnosisOptions> parsed = ParseFlags(options.flags, *source.value().bench);
  if (!parsed) {
    return Fail(parsed.error(), kExitBadInput);
  }
  for (const std::string& note : source.value().notes) {
    PrintError("note: " + note);
  }
  NoteOtherBench(
      options.recording, source.value().bench_named, options.flags.bench, *source.value().bench);
  core::DiagnosisOptions diagnose = parsed.value();
  FollowRecord(options.flags, source.value().samples, source.value().period_s, diagnose);
  if (const core::Status fits = CheckPeriod(diagnose.calibration, diagnose.period_s); !fits) {
    return Fail(fits.error(), kExitBadInput);
  }
  FigureContext context;
  context.name = source.value().name;
  context.footer = "faultlab " + std::string(Version());
  context.faults = source.value().faults;
  const core::Result<Figure> figure =
      MakeFigure(options.figure, source.value().samples, diagnose, std::move(context));
  if (!figure) {
    return Fail(figure.error(), kExitBadInput);
  }
  const core::Status written = WriteFigure(figure.value(), options.output, options.scale);
  if (written) {
    return kExitOk;
  }
  const bool theirs = written.error().code == core::ErrorCode::kInvalid;  // scale
  return Fail(written.error(), theirs ? kExitBadInput : kExitFailure);
}

}  // namespace faultlab::server
