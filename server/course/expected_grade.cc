#include "server/course/expected_grade.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>

namespace faultlab::server::course {
namespace {

namespace json = boost::json;

/// Of the best test between two records at this distance, Phi(-sqrt(2 D) / 2).
double ErrorAt(double kl_nats) {
  return 0.5 * std::erfc(0.5 * std::sqrt(std::max(0.0, kl_nats)));
}

double PointsWith(const Rubric& rubric, double seen, double right) {
  const double weights = rubric.detection + rubric.isolation + rubric.value + rubric.confidence;
  const double sum = rubric.detection * seen + (rubric.isolation + rubric.value) * right +
                     rubric.confidence * (1.0 - right * (1.0 - right));
  return 100.0 * sum / weights;
}

}  // namespace

ExpectedGrade ExpectGrade(const Rubric& rubric,
                          std::span<const LikelyDraw> draws,
                          std::span<const core::FaultIsolability> judged,
                          double kl_separable_nats) {
  // A healthy rig is taken for the fault that is the least of all.
  double least = 0.0;
  if (!judged.empty()) {
    least = std::ranges::min(judged, {}, &core::FaultIsolability::kl_nominal_nats).kl_nominal_nats;
  }
  ExpectedGrade out;
  out.hardest_points = 101.0;
  double squares = 0.0;
  auto of = judged.begin();
  for (const LikelyDraw& draw : draws) {
    double seen = 1.0 - ErrorAt(least);
    double right = seen;
    if (draw.fault) {
      seen = right = 1.0 - ErrorAt(of->kl_nominal_nats);
      for (const core::NearestRival& rival : of->rival) {
        if (rival.component == draw.fault->component || rival.kl_nats < kl_separable_nats) continue;
        right *= 1.0 - ErrorAt(rival.kl_nats);
      }
      ++of;
    }
    const double points = PointsWith(rubric, seen, right);
    out.points += draw.share * points;
    squares += draw.share * points * points;
    if (points < out.hardest_points) {
      out.hardest = draw;
      out.hardest_points = points;
    }
  }
  out.spread = std::sqrt(std::max(0.0, squares - out.points * out.points));
  return out;
}

json::object ToJson(const ExpectedGrade& expected) {
  const auto tenth = [](double points) { return std::round(10.0 * points) / 10.0; };
  const auto& fault = expected.hardest.fault;
  return {{"points", tenth(expected.points)},
          {"spread", tenth(expected.spread)},
          {"hardest",
           {{"component", fault ? json::value(core::Name(fault->component)) : nullptr},
            {"value", fault ? json::value(fault->value) : nullptr},
            {"points", tenth(expected.hardest_points)}}}};
}

}  // namespace faultlab::server::course
