#include "server/cli/plot.h"

#include <boost/json/serialize.hpp>
#include <utility>

#include "server/cli/console.h"
#include "server/cli/recording_source.h"
#include "server/csv/file_io.h"
#include "server/plots/figure_json.h"
#include "server/plots/record_figure.h"
#include "server/plots/render.h"

namespace faultlab::server {

int RunPlot(const PlotOptions& options) {
  core::Result<core::DiagnoseOptions> parsed = ParseFlags(options.flags);
  if (!parsed) {
    return Fail(parsed.error(), kExitBadInput);
  }
  const core::Result<SourceRecording> source = LoadRecording(options.recording, options.data_dir);
  if (!source) {
    return Fail(source.error(), kExitBadInput);
  }
  for (const std::string& note : source.value().notes) {
    PrintError("note: " + note);
  }
  core::DiagnoseOptions diagnose = parsed.value();
  diagnose.period_s = source.value().period_s;
  FigureContext context;
  context.name = source.value().name;
  context.footer = "faultlab " + std::string(Version());
  context.faults = source.value().faults;
  const core::Result<Figure> figure =
      MakeFigure(options.figure, source.value().samples, diagnose, std::move(context));
  if (!figure) {
    return Fail(figure.error(), kExitBadInput);
  }
  std::string bytes;
  if (options.output.ends_with(".json")) {
    bytes = boost::json::serialize(ToJson(figure.value())) + "\n";
  } else {
    RenderOptions render;
    render.scale = options.scale;
    core::Result<std::string> png = RenderPng(figure.value(), render);
    if (!png) {
      const bool ours = png.error().code == core::ErrorCode::kUnavailable;
      return Fail(png.error(), ours ? kExitFailure : kExitBadInput);
    }
    bytes = std::move(png).value();
  }
  const core::Status written = WriteFile(options.output, bytes);
  return written ? kExitOk : Fail(written.error(), kExitFailure);
}

}  // namespace faultlab::server
