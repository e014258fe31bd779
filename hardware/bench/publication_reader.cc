#include "hardware/bench/publication_reader.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hardware/bench/value_bounds.h"

namespace faultlab::hardware {
namespace {

constexpr std::size_t kFaultsMax = 100;
constexpr std::size_t kSourceBytesMax = 200;

void ReadThree(TomlTable& table, const std::string& key, std::array<double, 3>& to) {
  std::vector<double> numbers;
  table.Numbers(key, numbers, -kValueMax, kValueMax);
  if (numbers.size() != to.size()) table.Refuse(key, "must be three numbers");
  std::copy(numbers.begin(), numbers.end(), to.begin());
}

void ReadFault(TomlTable& table, core::Bench& bench) {
  core::PublishedFault fault;
  table.Text("component", fault.component);
  const std::optional<core::Component> component = bench.Find(fault.component);
  if (!component) table.Refuse("component", "must be the symbol of a [[component]]");
  table.Number("value", fault.value, kValueMin, kValueMax);
  const std::vector<double>& listed = component->info().published;
  if (std::ranges::find(listed, fault.value) == listed.end()) {
    table.Refuse("value", "must be one of `published` of the component " + fault.component);
  }
  if (bench.published.Find(fault.component, fault.value) != nullptr) {
    table.Refuse("value", "stands twice in this file");
  }
  ReadThree(table, "swa", fault.swa);
  ReadThree(table, "sia", fault.sia);
  fault.identified = -1.0;
  table.Number("identified", fault.identified, kValueMin, kValueMax);
  if (fault.identified < 0.0) table.Refuse("identified", "is missing");
  table.Integers("tables", fault.tables, 0, 1000, "of swa, sia and identified, 0 for none");
  bench.published.faults.push_back(std::move(fault));
}

}  // namespace

void ReadPublication(TomlTable& root, core::Bench& bench) {
  TomlTable& table = root.Sub("published");
  if (!root.Has("published")) return;
  table.Text("source", bench.published.source);
  if (bench.published.source.empty() || bench.published.source.size() > kSourceBytesMax) {
    table.Refuse("source", "must name the publication, in at most 200 characters");
  }
  constexpr std::size_t kFrictionsMax = 4;
  table.Numbers("mc_nm", bench.published.mc_nm, 0.0, kValueMax);
  if (bench.published.mc_nm.size() > kFrictionsMax) table.Refuse("mc_nm", "must be at most four");
  const std::vector<TomlTable*> faults = table.Subs("fault");
  if (faults.size() > kFaultsMax) table.Refuse("fault", "must stand at most 100 times");
  for (TomlTable* fault : faults) ReadFault(*fault, bench);
}

}  // namespace faultlab::hardware
