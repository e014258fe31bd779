#include "server/api/metrics_text.h"
#include "core/types/number_text.h"

namespace faultlab::server {
namespace {

std::string Seconds(double value) {
  return core::Format("%.9g", value);
}

/// `labels` with one more.
std::string With(const std::string& labels, std::string_view name, std::string_view value) {
  const std::string more = Label(name, value);
  if (labels.empty()) return more;
  return labels.substr(0, labels.size() - 1) + "," + more.substr(1);
}

}  // namespace

std::string Label(std::string_view name, std::string_view value) {
  std::string out = "{" + std::string(name) + "=\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') out.push_back('\\');
    if (c == '\n') {
      out.append("\\n");
    } else {
      out.push_back(c);
    }
  }
  return out.append("\"}");
}

void MetricsText::Head(std::string_view name, std::string_view type) {
  if (last_ == name) return;
  last_ = name;
  text_.append("# TYPE ").append(name).append(" ").append(type).append("\n");
}

void MetricsText::Add(std::string_view name,
                      std::string_view type,
                      std::uint64_t value,
                      const std::string& labels) {
  Head(name, type);
  text_.append(name).append(labels).append(" ").append(std::to_string(value)).append("\n");
}

void MetricsText::AddHistogram(const std::string& name,
                               const hardware::TimeHistogram& histogram,
                               const std::string& labels) {
  Head(name, "histogram");
  const auto line = [&](std::string_view end, const std::string& tags, const std::string& value) {
    text_.append(name).append(end).append(tags).append(" ").append(value).append("\n");
  };
  std::uint64_t below = 0;
  for (std::size_t bucket = 0; bucket < histogram.counts.size(); ++bucket) {
    below += histogram.counts[bucket];
    const bool bounded = bucket < hardware::TimeHistogram::kBoundsUs.size();
    const std::string bound =
        bounded ? Seconds(static_cast<double>(hardware::TimeHistogram::kBoundsUs[bucket]) * 1e-6)
                : "+Inf";
    line("_bucket", With(labels, "le", bound), std::to_string(below));
  }
  line("_sum", labels, Seconds(histogram.sum_s));
  line("_count", labels, std::to_string(below));
}

}  // namespace faultlab::server
