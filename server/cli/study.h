#pragma once

#include <string>

namespace faultlab::server {

struct StudyCommandOptions {
  std::string bench;                             ///< FILE.toml; empty: the paper's
  std::string recording;                         ///< CSV file
  std::string windows = "50,100,200";            ///< K of SWA; empty: no SWA
  std::string integrals = "20:5,100:20,500:20";  ///< K:m of SIA; empty: no SIA
  std::string change = "auto";                   ///< "auto", "none" or the time in seconds
  double from_s = 0.5;                           ///< the start-up of the motor lies before it
  int order = 1;
  bool exact = false;   ///< SIA with the paper's integration rule inverted
  bool affine = false;  ///< a constant column
  bool json = false;
  std::string plots_dir;  ///< swa.png and sia.png there; empty: none
};

/// Runs every window over one record in one call (paper Figures 17-20): how soon each settles after
/// the fault, how large its spread is, how often the input is too poor for it.
int RunStudy(const StudyCommandOptions& options);

}  // namespace faultlab::server
