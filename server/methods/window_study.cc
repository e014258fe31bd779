#include "server/methods/window_study.h"

#include <algorithm>
#include <boost/json/array.hpp>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/types/number_text.h"
#include "server/json/number_or_null.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Result;
using core::VariantSpec;

std::vector<std::string_view> Split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(separator), text.size());
    parts.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return parts;
}

std::optional<int> ParseCount(std::string_view text) {
  int value = 0;
  const std::from_chars_result read =
      std::from_chars(text.data(), text.data() + text.size(), value);
  return read.ec == std::errc() && read.ptr == text.data() + text.size() && value > 0
             ? std::optional(value)
             : std::nullopt;
}

/// Each order with each window, each once.
Result<std::vector<VariantSpec>> VariantsOf(const StudyRequest& request,
                                            const StudiedRecord& record) {
  const core::Error wrong_orders =
      core::Refuse("study_orders_wrong", "order", {{"most", core::kOrderMax}});
  const core::Error too_many = core::Refuse("study_count_outside", "k", {{"most", kStudiedMax}});
  std::vector<VariantSpec> variants;
  const auto add = [&variants](const VariantSpec& spec) {
    const bool known = std::ranges::any_of(variants, [&](const VariantSpec& each) {
      return each.order == spec.order && core::DifferInOrderAlone(each, spec);
    });
    if (!known) variants.push_back(spec);
    return variants.size() <= kStudiedMax;
  };
  const std::vector<std::string_view> orders = Split(request.orders, ',');
  if (orders.empty()) return wrong_orders;
  for (const std::string_view order : orders) {
    VariantSpec spec;
    spec.channel = record.bench.structure->estimated;
    spec.affine = request.affine;
    spec.period_s = record.period_s;
    spec.order = ParseCount(order).value_or(0);
    if (spec.order < 1 || spec.order > core::kOrderMax) return wrong_orders;
    for (const std::string_view part : Split(request.windows, ',')) {
      const std::optional<int> window = ParseCount(part);
      if (!window) return core::Refuse("study_windows_wrong", "k");
      spec.window_samples = *window;
      if (!add(spec)) return too_many;
    }
    spec.method = core::EstimatorMethod::kSia;
    spec.sia_mode = request.exact ? core::SiaMode::kExact : core::SiaMode::kPaper;
    spec.delta_s = request.exact ? record.delta_s : 0.0;
    for (const std::string_view part : Split(request.integrals, ',')) {
      const std::size_t colon = std::min(part.find(':'), part.size());
      const std::optional<int> window = ParseCount(part.substr(0, colon));
      const std::optional<int> integral = ParseCount(part.substr(std::min(colon + 1, part.size())));
      if (!window || !integral) return core::Refuse("study_pairs_wrong", "km");
      spec.window_samples = *window;
      spec.integral_samples = *integral;
      if (!add(spec)) return too_many;
    }
  }
  if (variants.empty()) return too_many;
  return variants;
}

Result<std::optional<double>> ChangeOf(const StudyRequest& request, const StudiedRecord& record) {
  if (request.change == "none") return std::optional<double>();
  if (request.change == "auto") {
    const double last_s = record.samples.empty() ? 0.0 : record.samples.back().t_s;
    for (const double each : record.changes_s) {
      if (each > request.from_s && each < last_s) return std::optional(each);
    }
    return std::optional<double>();
  }
  const std::optional<double> at_s = core::ParseNumber(request.change);
  if (!at_s || !std::isfinite(*at_s)) return core::Refuse("study_change_wrong", "change");
  return at_s;
}

std::size_t IndexAt(std::span<const core::Sample> samples, double t_s) {
  const auto at = std::ranges::lower_bound(samples, t_s, {}, &core::Sample::t_s);
  return static_cast<std::size_t>(at - samples.begin());
}

/// In the words of the request.
core::Error InItsWords(core::Error error, const std::vector<VariantSpec>& variants) {
  const std::size_t slash = std::min(error.field.find('/'), error.field.size());
  const std::string which = error.field.substr(std::min(slash + 1, error.field.size()));
  const auto at = static_cast<std::size_t>(ParseCount(error.field.substr(0, slash)).value_or(0));
  const bool swa = at < variants.size() && variants[at].method == core::EstimatorMethod::kSwa;
  error.field = which == "sia_mode" ? "exact" : which == "order" ? "order" : swa ? "k" : "km";
  return error;
}

json::object SpreadJson(const core::Spread& spread) {
  return {{"mean", NumberOrNull(spread.mean)},
          {"sd", NumberOrNull(spread.standard_deviation)},
          {"sigma", NumberOrNull(spread.reported_sigma)}};
}

json::object LeftJson(const core::OrderEvidence& left, int order) {
  return {{"count", left.count},
          {"rms", NumberOrNull(left.rms)},
          {"ljung_box", NumberOrNull(left.ljung_box)},
          {"white_below", NumberOrNull(left.white_below)},
          {"white", std::isfinite(left.ljung_box) ? json::value(left.white()) : nullptr},
          {"bic", NumberOrNull(left.bic)},
          {"order", order}};
}

}  // namespace

int WindowStudy::OrderFor(const core::WindowStudyRow& row, bool after) const {
  int order = 0;
  double least = std::numeric_limits<double>::infinity();
  for (const core::WindowStudyRow& each : rows) {
    const double bic = after ? each.left_after.bic : each.left_before.bic;
    if (!core::DifferInOrderAlone(each.spec, row.spec) || !(bic < least)) continue;
    least = bic;
    order = each.spec.order;
  }
  return order;
}

Result<WindowStudy> StudyRecord(const StudyRequest& request, const StudiedRecord& record) {
  TRY(const auto asked, VariantsOf(request, record));
  WindowStudy study;
  study.period_s = record.period_s;
  study.from_s = request.from_s;
  TRY(study.change_s, ChangeOf(request, record));
  std::span<const core::Sample> samples = record.samples;
  if (!(request.from_s >= 0.0) || !std::isfinite(request.from_s)) {
    return core::Refuse("study_start_wrong", "from_s");
  }
  // A change is known to a moment: nearer ones are the same.
  constexpr double kSameS = 0.5;
  if (study.change_s) {
    const double at_s = *study.change_s;
    for (const double each : record.changes_s) {
      if (each < at_s - kSameS) study.from_s = std::max(study.from_s, each);
      if (each > at_s + kSameS && !study.until_s) study.until_s = each;
    }
  }
  if (study.until_s) samples = samples.first(IndexAt(samples, *study.until_s));
  if (const std::size_t most = record.work_max / asked.size(); samples.size() > most) {
    const std::size_t start = IndexAt(samples, study.from_s);
    const std::size_t at = study.change_s ? IndexAt(samples, *study.change_s) : start;
    const std::size_t from = std::max(std::min(start, at), at - std::min(at, most / 2));
    samples = samples.subspan(from, std::min(most, samples.size() - from));
    if (!samples.empty()) study.from_s = std::max(study.from_s, samples.front().t_s);
  }
  study.samples = samples.size();
  const std::size_t start = IndexAt(samples, study.from_s);
  std::size_t at = study.change_s ? IndexAt(samples, *study.change_s) : samples.size();
  if (study.change_s && (at <= start || at == samples.size())) {
    return core::Refuse("study_change_outside", "change");
  }
  std::vector<VariantSpec> variants;
  for (const VariantSpec& spec : asked) {
    const auto transient = static_cast<std::size_t>(core::TransientSamples(spec));
    const bool fits =
        start + transient < at && (!study.change_s || at + transient < samples.size());
    if (fits) {
      variants.push_back(spec);
    } else {
      study.left_out.push_back(core::Name(spec));
    }
  }
  if (variants.empty()) return core::Refuse("study_no_room", "k");
  auto rows = core::StudyWindows(samples, start, at, variants, record.curves);
  if (!rows) return InItsWords(rows.error(), variants);
  study.rows = std::move(rows).value();
  return study;
}

json::object ToJson(const WindowStudy& study) {
  const auto variant = [&](const core::WindowStudyRow& row) {
    const bool changed = !row.after.empty();
    json::array parameters;
    for (std::size_t j = 0; j < row.parameters.size(); ++j) {
      parameters.push_back(
          json::object{{"name", row.parameters[j]},
                       {"before", SpreadJson(row.before[j])},
                       {"after", changed ? json::value(SpreadJson(row.after[j])) : nullptr}});
    }
    const double settling_s =
        row.settling_samples < 0 ? core::kAbsent : row.settling_samples * study.period_s;
    return json::object{
        {"name", row.name},
        {"method", row.spec.method == core::EstimatorMethod::kSwa ? "swa" : "sia"},
        {"order", row.spec.order},
        {"window", row.spec.window_samples},
        {"integral", row.spec.integral_samples},
        {"transient_s", NumberOrNull(row.transient_samples * study.period_s)},
        {"settling_s", NumberOrNull(settling_s)},
        {"unexcited_share", NumberOrNull(row.unexcited_share)},
        {"parameters", std::move(parameters)},
        {"left",
         {{"before", LeftJson(row.left_before, study.OrderFor(row, false))},
          {"after",
           changed ? json::value(LeftJson(row.left_after, study.OrderFor(row, true))) : nullptr}}}};
  };
  return {{"samples", study.samples},
          {"period_s", study.period_s},
          {"from_s", study.from_s},
          {"change_s", NumberOrNull(study.change_s)},
          {"until_s", NumberOrNull(study.until_s)},
          {"left_out", ListOf(study.left_out)},
          {"variants", ListOf(study.rows, variant)}};
}

}  // namespace faultlab::server
