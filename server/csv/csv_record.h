#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::server {

/// Limits above which a file is refused with ErrorCode::kTooLarge. Bytes are counted after
/// decompression, so that a small gzip file cannot fill the memory.
struct CsvLimits {
  std::size_t bytes_max = std::size_t{256} << 20;
  std::size_t rows_max = 4'000'000;
};

/// The recording in a file.
struct CsvRecord {
  /// Ascending index, 0 for the first row. A missing row is a jump of the index; a lost reading
  /// (empty cell or NaN) is core::kAbsent. t_s is the file's own time.
  std::vector<core::Sample> samples;
  double period_s = 0.0;              ///< step of the time base, seconds
  std::vector<std::string> channels;  ///< names found, canonical order: "t_s", "uc_v", "um_v", ..
  std::vector<std::string> comments;  ///< lines that begin with '#', without it
  /// Sentences about content that was accepted but may matter: gaps, lost readings, ignored
  /// columns.
  std::vector<std::string> notes;
  /// Those notes of columns that may be what the file lacks: part of any answer about it.
  std::vector<std::string> questions;
  std::int64_t missing_samples = 0;  ///< rows missing according to the time base
};

/// Parses the text of a CSV file. `name` precedes each message ("file.csv:12: column um_v: ..").
///   header: t_s, uc_v, um_v and any of ua_v, ia_a, n_rpm, in any order, or other names and units
///   (csv_header.h); titles may stand above it, and it may be a comment (csv_header_line.h); a
///   second line may contain the units; unknown columns are noted and ignored;
///   cells are separated by commas, or by semicolons, tabs, blanks or '|', and then decimal commas
///   are allowed too; in quotes they belong to the cell; '#' begins a comment line; Windows line
///   ends and a UTF-8 mark are accepted. A time of day counts from the first row. t_s must increase
///   by one period (or by whole periods where rows are missing); uc_v must be finite; the other
///   channels may be empty or NaN where a reading was lost.
/// Errors: kInvalid (`field` is the column) or kTooLarge.
core::Result<CsvRecord> ParseCsv(std::string_view text,
                                 std::string_view name,
                                 const CsvLimits& limits = {});

/// Reads a file, through gzip when its name ends in ".gz"; "-" is the standard input.
core::Result<CsvRecord> ReadCsv(const std::string& path, const CsvLimits& limits = {});

}  // namespace faultlab::server
