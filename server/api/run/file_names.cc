#include "server/api/run/file_names.h"

#include <boost/json.hpp>

#include "core/types/utf8.h"
#include "server/api/iso8601.h"
#include "server/api/request.h"
#include "server/experiment/plan_json.h"
#include "server/json/kept_json.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::size_t kNameBytesInFile = 80;

/// Without what file systems refuse or shells read.
std::string Tidied(const std::string& text) {
  constexpr std::string_view kRefused = "/\\:*?\"<>|'`$&;#%{}~!";
  std::string out;
  for (const char c : text) {
    const bool blank = static_cast<unsigned char>(c) <= ' ' || c == '\x7f';
    const char next = blank || kRefused.find(c) != std::string_view::npos ? '-' : c;
    if (next == '-' && (out.empty() || out.back() == '-')) continue;
    out += next;
  }
  while (!out.empty() && (out.back() == '-' || out.back() == '.')) out.pop_back();
  while (!out.empty() && out.front() == '.') out.erase(0, 1);
  return out;
}

/// "R1", the component of the first planned fault.
std::string FirstFault(const RunRecord& record) {
  const json::value plan = ParsedOr(record.plan_json);
  const json::value* faults = MemberIn(plan, "faults");
  if (faults == nullptr || !faults->is_array() || faults->get_array().empty()) return {};
  return TextIn(faults->get_array().front(), "component");
}

std::string WhatOf(const RunRecord& record) {
  if (!record.name.empty()) return record.name;
  if (record.rig.empty()) return record.id;
  const std::string fault = HidesFaults(record.plan_json) ? "" : FirstFault(record);
  return fault.empty() ? record.rig : record.rig + "_" + fault;
}

}  // namespace

std::string FileNameOf(const RunRecord& record, std::string_view kind, std::string_view extension) {
  const std::string what = Tidied(WhatOf(record));
  return FileNameOf(record.created_at, what.empty() ? record.id : what, kind, extension);
}

std::string FileNameOf(WallTime at,
                       std::string_view what,
                       std::string_view kind,
                       std::string_view extension) {
  const std::string iso = Iso8601(at);  // 2026-11-21T01:02:03.456Z
  std::string name = iso.substr(0, 10) + "_" + iso.substr(11, 2) + iso.substr(14, 2);
  const std::string tidied = Tidied(std::string(core::CutUtf8(what, kNameBytesInFile)));
  if (!tidied.empty()) name.append("_").append(tidied);
  return name.append("_").append(kind).append(".").append(extension);
}

}  // namespace faultlab::server
