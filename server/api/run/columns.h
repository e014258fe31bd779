#pragma once

#include <span>
#include <string>
#include <string_view>

#include "core/types/sample.h"

// Long JSON is put together as text: a tree of a million numbers would take ten times the memory.
namespace faultlab::server {

/// Shortest text that reads back to the same bits; null for NaN.
void AppendNumber(std::string& out, double value);

/// ,"name":[..]
template <typename Items, typename Get>
void AppendColumn(std::string& out, std::string_view name, const Items& items, Get get) {
  out.append(",\"").append(name).append("\":[");
  bool first = true;
  for (const auto& item : items) {
    if (!first) out.push_back(',');
    first = false;
    AppendNumber(out, get(item));
  }
  out.push_back(']');
}

/// ,"index":[..],"t_s":[..],"uc_v":[..],"um_v":[..],"ua_v":[..],"ia_a":[..],"n_rpm":[..]
std::string SampleColumns(std::span<const core::Sample> samples);

}  // namespace faultlab::server
