#include "server/demonstration/demonstration.h"

#include <algorithm>
#include <charconv>
#include <string>
#include <utility>

#include "core/plant/simulate_record.h"
#include "core/signals/excitation.h"

namespace faultlab::server {
namespace {

/// Of the converters' noise and the friction's; any number would do.
constexpr std::uint64_t kSeed = 7;
/// Farther from nominal the parameters of the model leave what a number can hold.
constexpr double kFactorMax = 1e9;

core::Error Wrong(std::string message) {
  return {core::ErrorCode::kInvalid, std::move(message), "changes", "change_wrong"};
}

core::Error NoComponent(const core::Bench& bench, const std::string& name) {
  std::string known;
  for (const core::Component each : bench.components()) {
    known.append(known.empty() ? "" : ", ").append(core::Name(each));
  }
  return core::Refuse("no_component", "changes", {{"component", name}, {"known", known}});
}

core::Result<core::Fault> ParseChange(std::string_view text, const core::Bench& bench) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) {
    return Wrong("A change is a component and its value: 'R1:100'.");
  }
  const std::string name(text.substr(0, colon));
  const auto component = bench.Find(name);
  if (!component) return NoComponent(bench, name);
  core::Fault change{*component};
  const char* end = text.data() + text.size();
  const auto [parsed_to, error] = std::from_chars(text.data() + colon + 1, end, change.value);
  const double factor = change.value / bench.nominal.Get(*component);
  const bool inside = factor > 1.0 / kFactorMax && factor < kFactorMax;
  if (error != std::errc{} || parsed_to != end || !inside) {
    return Wrong(
        "The value of " + name +
        " must be above 0, in the SI unit, not farther than a billion times from nominal.");
  }
  return change;
}

}  // namespace

core::Result<std::vector<core::Fault>> ParseChanges(std::string_view text,
                                                    const core::Bench& bench) {
  std::vector<core::Fault> changes;
  while (!text.empty()) {
    const std::size_t comma = text.find(',');
    TRY(const auto change, ParseChange(text.substr(0, comma), bench));
    const core::Component component = change.component;
    const auto same = [component](const core::Fault& each) { return each.component == component; };
    if (std::ranges::any_of(changes, same)) {
      return Wrong("'" + std::string(core::Name(component)) + "' is named twice.");
    }
    changes.push_back(change);
    text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
  }
  return changes;
}

core::Result<Demonstration> PlayDemonstration(const core::Bench& bench,
                                              std::vector<core::Fault> changes,
                                              DemonstrationLength length) {
  if (bench.profiles.empty()) {
    return core::Refuse("no_simulator", "bench", {{"bench", bench.name}})
        .As(core::ErrorCode::kInvalid);
  }
  const double fault_at_s = static_cast<double>(length.healthy) * bench.period_s;
  for (core::Fault& change : changes) change.at_s = fault_at_s;
  const double duration_s = static_cast<double>(length.healthy + length.faulty) * bench.period_s;
  TRY(const auto input, core::Generate(bench.excitation, duration_s, bench.period_s));
  return Demonstration{
      core::SimulateRecord(
          bench.profiles.front(), bench.nominal, input, changes, kSeed, bench.period_s),
      length.healthy};
}

core::PlantParameters ChangedPlant(const core::Bench& bench,
                                   const std::vector<core::Fault>& changes) {
  core::PlantParameters plant = bench.nominal;
  for (const core::Fault& change : changes) plant.Set(change.component, change.value);
  return plant;
}

}  // namespace faultlab::server
