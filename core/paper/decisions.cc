#include "core/paper/decisions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "core/structures/inverting_amplifier/inverting_amplifier.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

/// What a question asks; kEnd asks nothing.
enum class Test { kEnd, kPole, kGain, kZero, kOpposite, kRatio, kSameWay };

struct Row {
  std::string_view question;
  Test test = Test::kEnd;
  int yes = -1;
  int no = -1;
  std::array<std::string_view, 5> symbols = {};  ///< of an end: parameters that lead there
};

constexpr Row EndOf(std::array<std::string_view, 5> symbols) {
  return {"", Test::kEnd, -1, -1, symbols};
}

// Fig. 21, derived from Eq. (4): the gain (R9, R12) scales only b0 and b1. The lag (C8), Ra and J
// do not change b0; of these, J keeps b1/a1, Ra changes b1/a1 in the same direction as a1, C8 in
// the opposite direction. R1 and B change b0, R1 in the opposite direction to a1, B in the same.
constexpr int kNominalEnd = 5;
constexpr std::array<Row, 15> kRows = {
    {{"a1 outside its band?", Test::kPole, 6, 1},
     {"b0 outside its band?", Test::kGain, 2, 3},
     EndOf({"R9", "R10", "R12", "R14", "R15"}),
     {"b1 outside its band?", Test::kZero, 4, kNominalEnd},
     {},
     {},
     {"b0 outside its band?", Test::kGain, 7, 10},
     {"a1 and b0 in opposite directions?", Test::kOpposite, 8, 9},
     EndOf({"R1"}),
     EndOf({"B"}),
     {"b1/a1 outside its band?", Test::kRatio, 11, 14},
     {"b1/a1 and a1 in the same direction?", Test::kSameWay, 12, 13},
     EndOf({"Ra"}),
     EndOf({"C8"}),
     EndOf({"J"})}};

/// The bench's components whose faults change these parameters of the structure.
std::vector<Component> Changing(const Bench& bench, const Row& row) {
  std::vector<Component> found;
  for (const Component component : bench.components()) {
    const auto parameter = static_cast<std::size_t>(component.info().parameter);
    const std::string_view symbol = bench.structure->parameters[parameter].symbol;
    if (std::ranges::find(row.symbols, symbol) != row.symbols.end()) found.push_back(component);
  }
  return found;
}

std::string Words(const Decision& at) {
  if (at.healthy) return "nominal";
  if (at.components.empty()) return "no component";
  std::string words;
  for (std::size_t i = 0; i < at.components.size(); ++i) {
    if (i > 0) words += i + 1 == at.components.size() ? " or " : ", ";
    words += Name(at.components[i]);
  }
  return words;
}

/// What the numbers say to a question: whether the first is beyond the second.
struct Answer {
  double value = 0.0;
  double threshold = 0.0;
  bool beyond = false;
};

Answer AnswerTo(Test test,
                const ContinuousTheta& nominal,
                const ContinuousTheta& estimate,
                const ContinuousTheta& band) {
  const auto outside = [](double value, double threshold) {
    return Answer{value, threshold, std::abs(value) > threshold};
  };
  const auto change = [&](std::size_t i) { return estimate[i] - nominal[i]; };
  const double ratio = estimate[1] / estimate[2] - nominal[1] / nominal[2];
  switch (test) {
    case Test::kGain:
      return outside(change(0), band[0]);
    case Test::kZero:
      return outside(change(1), band[1]);
    case Test::kPole:
      return outside(change(2), band[2]);
    case Test::kOpposite:
      return {change(2), 0.0, change(0) * change(2) < 0.0};
    case Test::kRatio:
      return outside(
          ratio, (band[1] + std::abs(nominal[1] / nominal[2]) * band[2]) / std::abs(estimate[2]));
    case Test::kSameWay:
      return {ratio, 0.0, ratio * change(2) > 0.0};
    case Test::kEnd:
      break;
  }
  return {};
}

}  // namespace

bool HasDecisions(const Bench& bench) {
  return !bench.published.source.empty() && bench.structure == &kInvertingAmplifier;
}

std::vector<Decision> DecisionsOf(const Bench& bench) {
  LAB_CHECK(HasDecisions(bench));
  std::vector<Decision> all(kRows.size());
  // Each stands before what follows it.
  for (std::size_t i = kRows.size(); i-- > 0;) {
    const Row& row = kRows[i];
    Decision& at = all[i];
    at = {row.question, row.yes, row.no, i == kNominalEnd, Changing(bench, row)};
    for (const int next : {row.yes, row.no}) {
      if (next < 0) continue;
      const auto& beyond = all[static_cast<std::size_t>(next)].components;
      at.components.insert(at.components.end(), beyond.begin(), beyond.end());
    }
    std::ranges::sort(at.components, ByIndex{});
  }
  return all;
}

std::vector<PathStep> FollowDecisions(const Bench& bench,
                                      const ContinuousTheta& nominal,
                                      const ContinuousTheta& estimate,
                                      const ContinuousTheta& band) {
  const std::vector<Decision> all = DecisionsOf(bench);
  std::vector<PathStep> path;
  for (std::size_t at = 0; kRows[at].test != Test::kEnd;) {
    const Answer answer = AnswerTo(kRows[at].test, nominal, estimate, band);
    const auto next = static_cast<std::size_t>(answer.beyond ? all[at].yes : all[at].no);
    PathStep step{std::string(all[at].question),
                  answer.beyond,
                  answer.value,
                  answer.threshold,
                  Words(all[next]),
                  all[next].components};
    // Before b0 is asked, a part and a healthy rig are possible still.
    const bool open = at <= 1 && kRows[next].test != Test::kEnd;
    if (open) {
      step.leads_to = all[next].question.substr(0, 2);
      step.components.clear();
    }
    path.push_back(std::move(step));
    at = next;
  }
  return path;
}

}  // namespace faultlab::core
