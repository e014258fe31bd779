#pragma once

#include <cstdint>
#include <string>

#include "core/types/result.h"

namespace faultlab::hardware {

/// The newest lease that a rig's agent has seen, and whose it was.
struct SeenLease {
  std::uint64_t epoch = 0;
  std::string holder;
  friend bool operator==(const SeenLease&, const SeenLease&) = default;
};

/// Keeps it over a restart of the agent: DIR/NAME.epoch, one line, "41 lab-3f/server-a-77".
/// Replaced in one step and on the disk before Raise returns. One thread.
class EpochFile {
 public:
  /// Makes nothing. kInvalid when there is a file that is not such a line: what the rig has seen is
  /// then unknown.
  static core::Result<EpochFile> Open(const std::string& directory, const std::string& rig);

  const SeenLease& seen() const { return seen_; }
  /// Known from now on, also when the disk refuses: then the error says so, and the next call with
  /// the same lease tries once more. Contract: the epoch does not sink.
  core::Status Raise(SeenLease lease);

 private:
  EpochFile(std::string path, SeenLease seen) : path_(std::move(path)), seen_(std::move(seen)) {}
  core::Status Write() const;

  std::string path_;
  SeenLease seen_;
  bool stored_ = true;
};

/// `directory`, or $HOME/.faultlab/state when empty.
std::string StateDirectory(const std::string& directory);

}  // namespace faultlab::hardware
