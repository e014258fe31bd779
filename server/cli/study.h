#pragma once

#include <string>

#include "server/methods/window_study.h"

namespace faultlab::server {

struct StudyCommandOptions {
  StudyRequest asked;
  std::string bench;      ///< FILE.toml; empty: the paper's
  std::string recording;  ///< CSV file
  bool json = false;
  std::string plots_dir;  ///< swa.png and sia.png there; empty: none
};

/// Runs every window over one record in one call (paper Figures 17-20): how soon each settles after
/// the fault, how large its spread is, how often the input is too poor for it.
int RunStudy(const StudyCommandOptions& options);

}  // namespace faultlab::server
