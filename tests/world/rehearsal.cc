#include "tests/world/rehearsal.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "tests/world/lab_world.h"
#include "tests/world/semester.h"

namespace faultlab::server::lab {
namespace {

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

std::string ToJson(const WeekFigures& figures) {
  return "{\"utilisation\":" + Number(figures.utilisation) +
         ",\"median_wait_min\":" + Number(figures.median_wait_min) +
         ",\"p95_wait_min\":" + Number(figures.p95_wait_min) +
         ",\"no_show_loss\":" + Number(figures.no_show_loss) +
         ",\"served\":" + Number(figures.served) + ",\"jain\":" + Number(figures.jain) + "}";
}

}  // namespace

namespace {

constexpr std::int64_t kStepsPerWorld = 10'000;

using Databases = std::vector<std::unique_ptr<Database>>;

/// One connection for each member; on SQLite one server alone uses a database.
core::Result<Databases> Open(const std::string& location) {
  Databases databases;
  if (location.empty()) return databases;
  for (int i = 0; i < 2; ++i) {
    DatabaseOptions options;
    options.location = location;
    auto opened = Database::Open(options);
    if (!opened.ok()) return opened.error();
    databases.push_back(std::move(opened).value());
    if (databases.back()->engine() == Engine::kSqlite) break;
  }
  LabState kept;
  const core::Status read = databases.front()->Read([&](Transaction& tx) -> core::Status {
    kept = lab_store::Load(tx);
    return core::Done{};
  });
  if (!read.ok()) return read.error();
  if (kept.rigs.empty()) return databases;
  return core::Error{core::ErrorCode::kConflict,
                     "this database has rigs; the rehearsal needs one of its own, which it fills "
                     "and empties",
                     "database"};
}

void RunWorlds(const RehearsalOptions& options,
               const Databases& databases,
               RehearsalReport& report) {
  rehearsal::WorldStore store;
  for (const auto& database : databases) store.databases.push_back(database.get());
  Random seeds(options.seed);
  std::uint64_t kind = options.seed;
  while (report.steps < options.steps && !report.broken_rules.contains(options.until_broken)) {
    const auto seed = static_cast<std::uint64_t>(seeds.Below(1LL << 62));
    rehearsal::LabWorld world(seed, kind++, store, report);
    const std::int64_t until = std::min(options.steps, report.steps + kStepsPerWorld);
    std::size_t rules = 0;
    while (report.steps < until) {
      world.Step();
      const auto& findings = world.oracle().findings();
      if (findings.size() == rules) continue;
      rules = findings.size();
      for (const auto& [rule, found] : findings) {
        const auto [first, is_new] = report.broken_rules.try_emplace(rule);
        if (!is_new) continue;
        first->second.first = "step " + std::to_string(report.steps) + " (" + world.About() +
                              "): " + rule + ": " + found.first;
        if (report.first_broken.empty()) report.first_broken = first->second.first;
      }
    }
    report.sessions += world.oracle().sessions();
    for (const auto& [rule, found] : world.oracle().findings()) {
      report.broken_rules[rule].count += found.count;
    }
  }
  for (const auto& [rule, found] : report.broken_rules) {
    const bool twice = rule == "one holder" || rule == "check between users";
    const bool stale = rule == "stale command" || rule == "member's lease";
    (twice   ? report.double_allocations
     : stale ? report.stale_commands_accepted
             : report.broken_invariants) += found.count;
  }
}

}  // namespace

core::Result<RehearsalReport> Rehearse(const RehearsalOptions& options) {
  const auto databases = Open(options.database);
  if (!databases.ok()) return databases.error();
  RehearsalReport report;
  RunWorlds(options, databases.value(), report);
  rehearsal::SimulateSemester(options.weeks, options.seed, options.timetable, report);
  return report;
}

std::string ToJson(const RehearsalReport& report) {
  const auto field = [](const char* name, std::int64_t value) {
    return std::string("\"") + name + "\":" + std::to_string(value) + ",";
  };
  std::string rules;
  for (const auto& [rule, found] : report.broken_rules) {
    rules += (rules.empty() ? "\"" : ",\"") + rule + "\":" + std::to_string(found.count);
  }
  rules = "{" + rules + "}";
  return "{" + field("steps", report.steps) +
         field("double_allocations", report.double_allocations) +
         field("stale_commands_accepted", report.stale_commands_accepted) +
         field("stale_commands_tried", report.stale_commands_tried) +
         field("commands_accepted", report.commands_accepted) +
         field("broken_invariants", report.broken_invariants) + field("sessions", report.sessions) +
         field("crashes", report.crashes) + field("clock_jumps", report.clock_jumps) +
         field("quarantines", report.quarantines) + "\"first_broken\":\"" + report.first_broken +
         "\",\"jain\":" + Number(report.jain) +
         ",\"days_estimate_held\":" + Number(report.days_estimate_held) +
         ",\"ours\":" + ToJson(report.ours) + ",\"fifo\":" + ToJson(report.fifo) +
         ",\"fifo_slots\":" + ToJson(report.fifo_slots) + "}";
}

}  // namespace faultlab::server::lab
