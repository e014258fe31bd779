#pragma once

#include <string>

#include "server/cli/diagnose.h"

namespace faultlab::server {

struct PlotOptions {
  std::string recording;  ///< a CSV file, or the id of a run in `data_dir`
  std::string figure = "signals";
  std::string output;  ///< FILE.png; FILE.json writes the figure as data
  std::string data_dir = "data";
  int scale = 1;
  DiagnosisFlags flags;
};

/// Draws one figure of a recording.
int RunPlot(const PlotOptions& options);

}  // namespace faultlab::server
