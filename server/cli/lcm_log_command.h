#pragma once

#include <string>

namespace faultlab::server {

/// `faultlab lcm export RECORDING -o FILE`: writes a recording as lcm-logger would have recorded it
/// from the live tap; lcm-logplayer plays it, lcm-spy shows it.
struct LcmExportOptions {
  std::string recording;  ///< CSV file, or the id of a stored run
  std::string output;
  std::string rig = "recording";  ///< channel FAULTLAB.<rig>.SAMPLE
  std::string run;                ///< name of the run on the bus; empty: the recording's
  std::string data_dir = "data";
  std::string bench;  ///< of a CSV file; empty: the paper's
};
int RunLcmExport(const LcmExportOptions& options);

/// `faultlab lcm import FILE -o RUN.csv`: converts a log of lcm-logger to a recording.
struct LcmImportOptions {
  std::string log;
  std::string output;
  std::string run;    ///< empty: the first in the log
  std::string bench;  ///< that its events name components of; empty: the paper's
};
int RunLcmImport(const LcmImportOptions& options);

}  // namespace faultlab::server
