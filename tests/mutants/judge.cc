// judge STEPS SEED [RULE [DATABASE]]: one rehearsal, until RULE is found broken. Prints the rules
// that were broken, one a line: rule, tab, how often, tab, the first finding. Exit code 0: none
// was, 1: some were, 2: it cannot run.
#include <cstdio>
#include <cstdlib>

#include "tests/world/rehearsal.h"

int main(int count, char** words) {
  namespace lab = faultlab::server::lab;
  if (count < 3) return 2;
  lab::RehearsalOptions options;
  options.steps = std::atoll(words[1]);
  options.seed = static_cast<std::uint64_t>(std::atoll(words[2]));
  options.weeks = 0;
  if (count > 3) options.until_broken = words[3];
  if (count > 4) options.database = words[4];
  const auto report = lab::Rehearse(options);
  if (!report.ok()) {
    std::fprintf(stderr, "%s\n", report.error().message.c_str());
    return 2;
  }
  for (const auto& [rule, found] : report.value().broken_rules) {
    std::printf(
        "%s\t%lld\t%s\n", rule.c_str(), static_cast<long long>(found.count), found.first.c_str());
  }
  return report.value().broken_rules.empty() ? 0 : 1;
}
