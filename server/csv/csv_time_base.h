#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "core/types/sample.h"
#include "server/csv/csv_record.h"

namespace faultlab::server {

/// "name:line: column c: message", the form of every message about a CSV file.
core::Error CsvError(std::string_view name,
                     std::uint32_t line,
                     std::string_view column,
                     std::string reason,
                     const std::string& message);

/// A time of day counts from the first row, and goes on at midnight.
void CountFromFirstRow(std::vector<core::Sample>& samples);

/// Leaves out the first rows where the clock begins again after them: a reset of the program that
/// wrote them, or what was left in a buffer.
/// @param line_of  of each sample; its first ones go too
/// @returns what to note; empty when nothing was left out
std::string LeaveOutBeforeRestart(std::vector<core::Sample>& samples,
                                  std::vector<std::uint32_t>& line_of);

/// Finds the period of record.samples[..].t_s and sets the indices, period_s, missing_samples and
/// the notes about gaps. `line_of[row]` is for messages.
///   period = median step, refined over the whole file and rounded to a microsecond when the whole
///   file agrees with that; index = nearest multiple of the period after the first row.
/// Refuses time that does not increase, a row further than kGridTolerance periods from its place,
/// two time bases in one file, and more rows missing than present.
std::optional<core::Error> AssignTimeBase(CsvRecord& record,
                                          std::span<const std::uint32_t> line_of,
                                          std::string_view name);

}  // namespace faultlab::server
