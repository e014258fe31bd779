#pragma once

#include <string>
#include <vector>

#include "server/cli/diagnose.h"

namespace faultlab::server {

struct PlotOptions {
  /// CSV files, or ids of runs in `data_dir`; several for a family of curves.
  std::vector<std::string> recordings;
  std::string figure = "signals";
  std::string output;  ///< FILE.png; FILE.json writes the figure as data
  std::string data_dir = "data";
  int scale = 1;
  DiagnosisFlags flags;
};

/// Draws one figure of a recording, or the family of curves of several.
int RunPlot(const PlotOptions& options);

}  // namespace faultlab::server
