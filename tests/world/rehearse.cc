// rehearse [OPTIONS]: the lab against random people, failures and crashes. Exit status: 0 every
// rule held, 1 one did not, 2 an option is wrong.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "tests/world/rehearsal.h"

int main(int count, char** words) {
  namespace lab = faultlab::server::lab;
  lab::RehearsalOptions options{.steps = 1'000'000, .seed = 1, .weeks = 2};
  bool json = false;
  CLI::App app(
      "The lab as it ships, on a clock of its own, against random people, failures and crashes.",
      "rehearse");
  app.footer("Example:\n  rehearse --steps 1000000 --seed 1");
  app.add_option("--steps", options.steps, "Random inputs")
      ->capture_default_str()
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1'000'000'000}));
  app.add_option("--seed", options.seed, "Same seed, same report")->capture_default_str();
  app.add_option("--weeks", options.weeks, "Simulated weeks")
      ->capture_default_str()
      ->check(CLI::Range(0, 1000));
  app.add_option(
      "--database",
      options.database,
      "SQLite file or postgresql: location without rigs, filled and emptied; default: in memory");
  app.add_flag(
      "--timetable", options.timetable, "In those weeks: opening hours, and hours of courses");
  app.add_flag("--json", json, "The report as one JSON object");
  try {
    app.parse(count, words);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const auto rehearsed = lab::Rehearse(options);
  if (!rehearsed.ok()) {
    std::fprintf(stderr, "rehearse: %s\n", rehearsed.error().message.c_str());
    return 1;
  }
  const lab::RehearsalReport& report = rehearsed.value();
  const bool held = report.broken_rules.empty();
  if (!json) {
    std::printf("%lld steps, %lld sessions, %lld crashes: %s\n",
                static_cast<long long>(report.steps),
                static_cast<long long>(report.sessions),
                static_cast<long long>(report.crashes),
                held ? "every rule held" : ("broken: " + report.first_broken).c_str());
  }
  std::printf("%s\n", lab::ToJson(report).c_str());
  return held ? 0 : 1;
}
