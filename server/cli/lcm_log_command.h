#pragma once

#include <string>

namespace faultlab::server {

/// `faultlab lcm export RECORDING -o FILE`: a recording as lcm-logger would have written it from
/// the live tap; lcm-logplayer plays it, lcm-spy shows it.
struct LcmExportOptions {
  std::string recording;  ///< CSV file, or the id of a stored run
  std::string output;
  std::string rig = "recording";  ///< channel FAULTLAB.<rig>.SAMPLE
  std::string run;                ///< name of the run on the bus; empty: the recording's
  std::string data_dir = "data";
};
int RunLcmExport(const LcmExportOptions& options);

/// `faultlab lcm import FILE -o RUN.csv`: what lcm-logger wrote of a run, as a recording.
struct LcmImportOptions {
  std::string log;
  std::string output;
  std::string run;  ///< empty: the first in the log
};
int RunLcmImport(const LcmImportOptions& options);

}  // namespace faultlab::server
