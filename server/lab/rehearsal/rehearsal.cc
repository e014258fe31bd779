#include "server/lab/rehearsal/rehearsal.h"

#include <cstdio>

#include "server/lab/rehearsal/random_world.h"
#include "server/lab/rehearsal/simulated_weeks.h"

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
         ",\"served\":" + Number(figures.served) + "}";
}

}  // namespace

RehearsalReport Rehearse(const RehearsalOptions& options) {
  RehearsalReport report;
  RunRandomWorlds(options.steps, options.seed, report);
  SimulateWeeks(options.weeks, options.seed, report);
  return report;
}

std::string ToJson(const RehearsalReport& report) {
  const auto field = [](const char* name, std::int64_t value) {
    return std::string("\"") + name + "\":" + std::to_string(value) + ",";
  };
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
         ",\"ours\":" + ToJson(report.ours) + ",\"fifo_slots\":" + ToJson(report.fifo_slots) + "}";
}

}  // namespace faultlab::server::lab
