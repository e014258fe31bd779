#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::server {

struct CsvWriteOptions {
  std::vector<std::string> comments;  ///< each becomes a line "# ..", line breaks become blanks
};

/// The text of a recording: t_s, uc_v, um_v and those of ua_v, ia_a, n_rpm, delta_s that hold any
/// number. Every number is the shortest text that reads back to the same bits; a lost reading is an
/// empty cell.
std::string FormatCsv(std::span<const core::Sample> samples, const CsvWriteOptions& options = {});
/// The same in pieces of some kilobytes.
void FormatCsv(std::span<const core::Sample> samples,
               const CsvWriteOptions& options,
               const std::function<void(std::string_view)>& take);

/// FormatCsv into a file, with gzip if the name ends in ".gz". The file is either complete or not
/// there.
core::Status WriteCsv(const std::string& path,
                      std::span<const core::Sample> samples,
                      const CsvWriteOptions& options = {});

}  // namespace faultlab::server
