#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "core/types/result.h"

namespace faultlab::server {

/// Bytes of a file, at most `bytes_max` (else kTooLarge). "-" is the standard input.
/// A name that ends in ".gz" is decompressed; the limit applies to the decompressed bytes.
core::Result<std::string> ReadFile(const std::string& path, std::size_t bytes_max);

/// Writes a temporary file beside the target, syncs and renames it: another process sees the old
/// file or the complete new one. A name that ends in ".gz" is compressed. "-" and devices are
/// written directly. On any error the temporary file is removed and the old file is unchanged.
core::Status WriteFile(const std::string& path, std::string_view bytes);

core::Result<std::string> Gunzip(std::string_view compressed,
                                 std::string_view name,
                                 std::size_t bytes_max);
std::string Gzip(std::string_view bytes);

bool IsGzipName(std::string_view path);

}  // namespace faultlab::server
