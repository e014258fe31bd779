#include "server/api/run/columns.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace faultlab::server {

void AppendNumber(std::string& out, double value) {
  if (!std::isfinite(value)) {
    out.append("null");
    return;
  }
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  out.append(text.data(), end);
}

void AppendSampleColumns(Spool& out, std::span<const core::Sample> samples) {
  AppendColumn(out, "index", samples, [](const auto& s) { return static_cast<double>(s.index); });
  AppendColumn(out, "t_s", samples, [](const auto& s) { return s.t_s; });
  AppendColumn(out, "uc_v", samples, [](const auto& s) { return s.uc_v; });
  AppendColumn(out, "um_v", samples, [](const auto& s) { return s.um_v; });
  AppendColumn(out, "ua_v", samples, [](const auto& s) { return s.ua_v; });
  AppendColumn(out, "ia_a", samples, [](const auto& s) { return s.ia_a; });
  AppendColumn(out, "n_rpm", samples, [](const auto& s) { return s.n_rpm; });
  const bool has_delta =
      std::ranges::any_of(samples, [](const auto& s) { return !std::isnan(s.delta_s); });
  if (has_delta) AppendColumn(out, "delta_s", samples, [](const auto& s) { return s.delta_s; });
}

}  // namespace faultlab::server
