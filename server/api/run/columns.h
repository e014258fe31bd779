#pragma once

#include <span>
#include <string>
#include <string_view>

#include "core/types/sample.h"
#include "server/spool.h"

// Long JSON is put together as text: a tree of a million numbers would take ten times the memory.
namespace faultlab::server {

inline constexpr std::size_t kPieceBytes = 16 << 10;

/// Shortest text that reads back to the same bits; null for NaN.
void AppendNumber(std::string& out, double value);

/// ,"name":[..]
template <typename Items, typename Get>
void AppendColumn(Spool& out, std::string_view name, const Items& items, Get get) {
  std::string piece = ",\"" + std::string(name) + "\":[";
  bool first = true;
  for (const auto& item : items) {
    if (!first) piece.push_back(',');
    first = false;
    AppendNumber(piece, get(item));
    if (piece.size() < kPieceBytes) continue;
    out.Append(piece);
    piece.clear();
  }
  out.Append(piece + "]");
}

/// ,"index":[..],"t_s":[..],"uc_v":[..],"um_v":[..],"ua_v":[..],"ia_a":[..],"n_rpm":[..]
void AppendSampleColumns(Spool& out, std::span<const core::Sample> samples);

}  // namespace faultlab::server
