#include "server/course/statistics.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "server/json/number_or_null.h"

namespace faultlab::server::course {
namespace {

namespace json = boost::json;

struct Seen {
  std::int64_t person = 0;
  std::string truth;
  std::optional<std::string> answer;
  bool right = false;
  double points = 0.0;
};

Seen SeenIn(const Trial& trial) {
  Seen seen;
  seen.person = trial.account;
  const json::value truth = json::parse(trial.truth);
  const json::array& faults = truth.at("faults").as_array();
  if (!faults.empty()) seen.truth = faults.front().at("component").as_string();
  if (trial.answer.empty()) return seen;
  const json::value answer = json::parse(trial.answer);
  const json::value& said = answer.at("component");
  seen.answer = said.is_null() ? std::string() : std::string(said.as_string());
  seen.right = json::parse(trial.grade).at("right").as_bool();
  seen.points = PointsOf(trial).value_or(0.0);
  return seen;
}

/// None where either does not vary.
std::optional<double> Correlation(const std::vector<std::pair<double, double>>& pairs) {
  constexpr std::size_t kLeast = 3;
  if (pairs.size() < kLeast) return std::nullopt;
  const auto n = static_cast<double>(pairs.size());
  double x = 0.0;
  double y = 0.0;
  for (const auto& [a, b] : pairs) {
    x += a / n;
    y += b / n;
  }
  double xx = 0.0;
  double yy = 0.0;
  double xy = 0.0;
  for (const auto& [a, b] : pairs) {
    xx += (a - x) * (a - x);
    yy += (b - y) * (b - y);
    xy += (a - x) * (b - y);
  }
  constexpr double kFlat = 1e-12;
  if (xx < kFlat || yy < kFlat) return std::nullopt;
  return xy / std::sqrt(xx * yy);
}

/// Each answered trial of the fault, with the person's mean points in the other ones.
std::optional<double> DiscriminationOf(const std::string& fault, const std::vector<Seen>& all) {
  std::map<std::int64_t, std::pair<double, int>> elsewhere;
  for (const Seen& each : all) {
    if (!each.answer || each.truth == fault) continue;
    auto& [sum, count] = elsewhere[each.person];
    sum += each.points;
    ++count;
  }
  std::vector<std::pair<double, double>> pairs;
  for (const Seen& each : all) {
    const auto others = elsewhere.find(each.person);
    if (!each.answer || each.truth != fault || others == elsewhere.end()) continue;
    pairs.emplace_back(each.right ? 1.0 : 0.0, others->second.first / others->second.second);
  }
  return Correlation(pairs);
}

FaultStatistics OfFault(const std::string& fault, const std::vector<Seen>& all) {
  FaultStatistics of;
  of.fault = fault;
  std::map<std::string, int> answers;
  int right = 0;
  for (const Seen& each : all) {
    if (each.truth != fault) continue;
    ++of.trials;
    if (!each.answer) continue;
    ++of.answered;
    ++answers[*each.answer];
    right += each.right ? 1 : 0;
    of.points += each.points;
  }
  if (of.answered > 0) {
    of.right = static_cast<double>(right) / of.answered;
    of.points /= of.answered;
  }
  of.answers.assign(answers.begin(), answers.end());
  std::ranges::stable_sort(of.answers,
                           [](const auto& a, const auto& b) { return a.second > b.second; });
  of.discrimination = DiscriminationOf(fault, all);
  return of;
}

}  // namespace

std::optional<double> PointsOf(const Trial& trial) {
  const std::string& counts = trial.awarded.empty() ? trial.grade : trial.awarded;
  if (counts.empty()) return std::nullopt;
  return json::parse(counts).at("points").to_number<double>();
}

Statistics StatisticsOf(std::span<const Trial> trials) {
  std::vector<Seen> all;
  for (const Trial& trial : trials) {
    if (trial.released_at && trial.state != TrialState::kVoid) all.push_back(SeenIn(trial));
  }
  Statistics out;
  std::set<std::int64_t> people;
  std::set<std::string> faults;
  double sum = 0.0;
  for (const Seen& each : all) {
    people.insert(each.person);
    faults.insert(each.truth);
    if (!each.answer) continue;
    ++out.answered;
    sum += each.points;
  }
  out.students = static_cast<int>(people.size());
  if (out.answered > 0) out.points = sum / out.answered;
  for (const std::string& fault : faults) out.faults.push_back(OfFault(fault, all));
  return out;
}

json::object ToJson(const Statistics& statistics) {
  const auto name = [](const std::string& symbol) -> json::value {
    return symbol.empty() ? json::value(nullptr) : json::value(symbol);
  };
  const auto answer = [&](const auto& symbol_and_count) {
    const auto& [symbol, count] = symbol_and_count;
    return json::object{{"component", name(symbol)}, {"count", count}};
  };
  const auto fault = [&](const FaultStatistics& of) {
    return json::object{{"component", name(of.fault)},
                        {"trials", of.trials},
                        {"answered", of.answered},
                        {"right", of.right},
                        {"points", of.points},
                        {"discrimination", NumberOrNull(of.discrimination)},
                        {"answers", ListOf(of.answers, answer)}};
  };
  return {{"students", statistics.students},
          {"answered", statistics.answered},
          {"points", NumberOrNull(statistics.points)},
          {"faults", ListOf(statistics.faults, fault)}};
}

}  // namespace faultlab::server::course
