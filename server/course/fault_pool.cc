#include "server/course/fault_pool.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>
#include <string>

#include "core/diagnosis/diagnosis_options.h"
#include "core/types/component_bounds.h"
#include "server/experiment/experiment_plan.h"
#include "server/json/json_reader.h"
#include "server/json/list_of.h"
#include "server/run/refusals.h"

namespace faultlab::server::course {
namespace {

namespace json = boost::json;

constexpr double kHealthyShareMax = 0.9;
constexpr double kItemWeightMax = 1000.0;
constexpr double kFactorMin = 1e-3;  // of the nominal value; nearer to 0 is a short circuit anyway
constexpr double kLastsMin = 0.1;

void ReadValues(ObjectReader& in, const json::array& values, PoolItem& item) {
  for (const json::value& value : values) {
    const double number = value.is_number() ? value.to_number<double>() : 0.0;
    if (!std::isfinite(number) || number <= 0.0 || number > core::kComponentValueMax) {
      in.Refuse("values", "fault_value_not_positive");
      return;
    }
    item.values.push_back(number);
  }
  if (values.empty()) {
    in.Refuse("values", "member_missing", {{"member", "values"}});
  }
}

core::Result<PoolItem> ParseItem(const json::value& value,
                                 const std::string& pointer,
                                 const core::Bench& bench) {
  const json::object* object = value.if_object();
  if (object == nullptr) {
    return core::Refuse("faults_unreadable", pointer);
  }
  ObjectReader in(*object, pointer);
  PoolItem item;
  const std::string name = in.Text("component", core::kSymbolBytesMax);
  if (const auto component = bench.Find(name)) {
    item.component = *component;
  } else {
    in.Refuse(refusal::At(refusal::NoComponent(bench, name), pointer + "/component"));
  }
  if (const json::array* values = in.ArrayOrNull("values", kItemsMax)) {
    ReadValues(in, *values, item);
  } else {
    item.low = in.Number("low", 0.0, core::kComponentValueMax);
    item.high = in.Number("high", 0.0, core::kComponentValueMax);
    if (item.low <= 0.0) {
      in.Refuse("low", "fault_value_not_positive");
    }
    if (item.high < item.low) {
      in.Refuse("high", "pool_range_backwards");
    }
  }
  const std::string_view kind = in.WordOr("kind", "abrupt", {"abrupt", "drift", "intermittent"});
  if (kind == "drift") item.kind = core::FaultKind::kDrift;
  if (kind == "intermittent") item.kind = core::FaultKind::kIntermittent;
  item.onset_from_s = in.Number("onset_from_s", 0.0, kRunSecondsMax);
  item.onset_to_s = in.NumberOr("onset_to_s", item.onset_from_s, 0.0, kRunSecondsMax);
  if (item.onset_to_s < item.onset_from_s) {
    in.Refuse("onset_to_s", "pool_range_backwards");
  }
  const double learnt_s = core::OptionsOf(bench).healthy_to_s;
  if (item.onset_from_s < learnt_s) {
    in.Refuse("onset_from_s", "onset_too_early", {{"lowest", learnt_s}});
  }
  if (item.kind != core::FaultKind::kAbrupt) {
    item.lasts_s = in.Number("lasts_s", kLastsMin, kRunSecondsMax);
  }
  item.weight = in.NumberOr("weight", 1.0, kFactorMin, kItemWeightMax);
  if (auto error = in.Finish()) return *error;
  return item;
}

// std's distributions differ between libraries; the engine does not.
double Unit(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

double LogBetween(double low, double high, double share) {
  return low == high ? low : std::exp(std::lerp(std::log(low), std::log(high), share));
}

/// Four digits, as a person would set it.
double Rounded(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 3.0);
  return std::round(value / unit) * unit;
}

core::Fault FaultOf(const PoolItem& item, double value, double at_s) {
  core::Fault fault{item.component, value, at_s, item.kind, 0.0};
  if (item.kind != core::FaultKind::kAbrupt) fault.until_s = at_s + item.lasts_s;
  return fault;
}

}  // namespace

core::Result<FaultPool> ParsePool(const json::object& body, const core::Bench& bench) {
  ObjectReader in(body, "/pool");
  FaultPool pool;
  pool.healthy_share = in.NumberOr("healthy_share", pool.healthy_share, 0.0, kHealthyShareMax);
  const json::array* items = in.ArrayOrNull("items", kItemsMax);
  if (auto error = in.Finish()) return *error;
  if (items == nullptr || items->empty()) {
    return core::Refuse("no_faults", "/pool/items");
  }
  for (std::size_t i = 0; i < items->size(); ++i) {
    TRY(auto item, ParseItem((*items)[i], "/pool/items/" + std::to_string(i), bench));
    pool.items.push_back(std::move(item));
  }
  return pool;
}

core::Result<FaultPool> ParsePool(std::string_view document, const core::Bench& bench) {
  TRY(auto body, ParseJsonObject(document));
  return ParsePool(body, bench);
}

json::object ToJson(const FaultPool& pool) {
  const auto item_to_json = [](const PoolItem& item) {
    json::object out{{"component", core::Name(item.component)},
                     {"kind", core::Name(item.kind)},
                     {"onset_from_s", item.onset_from_s},
                     {"onset_to_s", item.onset_to_s},
                     {"weight", item.weight}};
    if (item.values.empty()) {
      out["low"] = item.low;
      out["high"] = item.high;
    } else {
      out["values"] = ListOf(item.values);
    }
    if (item.kind != core::FaultKind::kAbrupt) out["lasts_s"] = item.lasts_s;
    return out;
  };
  return {{"items", ListOf(pool.items, item_to_json)}, {"healthy_share", pool.healthy_share}};
}

std::vector<core::Fault> Representatives(const FaultPool& pool) {
  std::vector<core::Fault> faults;
  for (const PoolItem& item : pool.items) {
    const double value = item.values.empty() ? Rounded(LogBetween(item.low, item.high, 0.5))
                                             : item.values[item.values.size() / 2];
    faults.push_back(FaultOf(item, value, std::midpoint(item.onset_from_s, item.onset_to_s)));
  }
  return faults;
}

std::vector<core::Fault> HardestToSee(const FaultPool& pool, const core::PlantParameters& nominal) {
  std::vector<core::Fault> out;
  for (const PoolItem& item : pool.items) {
    const double healthy = nominal.Get(item.component);
    const std::vector<double> values =
        item.values.empty() ? std::vector<double>{item.low, item.high} : item.values;
    std::optional<double> below;
    std::optional<double> above;
    for (const double value : values) {
      if (value <= healthy) below = std::max(below.value_or(value), value);
      if (value > healthy) above = std::min(above.value_or(value), value);
    }
    if (below) out.push_back(FaultOf(item, *below, item.onset_from_s));
    if (above) out.push_back(FaultOf(item, *above, item.onset_from_s));
  }
  return out;
}

std::vector<LikelyDraw> LikelyDraws(const FaultPool& pool) {
  constexpr int kOfRange = 3;
  std::vector<LikelyDraw> out;
  if (pool.healthy_share > 0.0) out.push_back({std::nullopt, pool.healthy_share});
  double weights = 0.0;
  for (const PoolItem& item : pool.items) weights += item.weight;
  for (const PoolItem& item : pool.items) {
    std::vector<double> values = item.values;
    if (values.empty() && item.low == item.high) values = {item.low};
    for (int i = 0; item.values.empty() && item.low < item.high && i < kOfRange; ++i) {
      values.push_back(Rounded(LogBetween(item.low, item.high, (i + 0.5) / kOfRange)));
    }
    const double share =
        (1.0 - pool.healthy_share) * item.weight / weights / static_cast<double>(values.size());
    for (const double value : values) {
      out.push_back({core::FaultSize{item.component, value}, share});
    }
  }
  return out;
}

double LastsUntil(const FaultPool& pool) {
  double until_s = 0.0;
  for (const PoolItem& item : pool.items) {
    until_s = std::max(until_s, item.onset_to_s + item.lasts_s);
  }
  return until_s;
}

std::vector<core::Fault> Draw(const FaultPool& pool,
                              const std::vector<int>& drawn,
                              std::uint64_t seed,
                              int* item) {
  std::mt19937_64 random(seed);
  *item = -1;
  if (Unit(random) < pool.healthy_share) return {};
  std::vector<int> had(pool.items.size(), 0);
  for (const int each : drawn) {
    if (each >= 0 && each < static_cast<int>(had.size())) ++had[static_cast<std::size_t>(each)];
  }
  const int least = *std::ranges::min_element(had);
  double sum = 0.0;
  for (std::size_t i = 0; i < had.size(); ++i) {
    if (had[i] == least) sum += pool.items[i].weight;
  }
  double place = Unit(random) * sum;
  std::size_t chosen = 0;
  for (std::size_t i = 0; i < had.size(); ++i) {
    if (had[i] != least) continue;
    chosen = i;
    place -= pool.items[i].weight;
    if (place < 0.0) break;
  }
  const PoolItem& of = pool.items[chosen];
  const double share = Unit(random);
  const double value =
      of.values.empty()
          ? Rounded(LogBetween(of.low, of.high, share))
          : of.values[std::min(
                of.values.size() - 1,
                static_cast<std::size_t>(share * static_cast<double>(of.values.size())))];
  // To a hundredth of a second: nobody reads a finer time from a chart.
  const double at_s =
      std::round(std::lerp(of.onset_from_s, of.onset_to_s, Unit(random)) * 100.0) / 100.0;
  *item = static_cast<int>(chosen);
  return {FaultOf(of, value, at_s)};
}

}  // namespace faultlab::server::course
