#include "server/diagnosis_json/diagnosis_json.h"

#include <array>
#include <span>
#include <string_view>

#include "core/paper/path_outcome.h"
#include "server/diagnosis_json/calibration_json.h"
#include "server/json/number_or_null.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::array<std::string_view, 3> kSwaNames = {"b0d", "b1d", "a1d"};
constexpr std::array<std::string_view, 3> kSiaNames = {"b0", "b1", "a1"};

json::value Bound(char bound) {
  return bound == 0 ? json::value(nullptr) : json::value(json::string(1, bound));
}

json::array Candidates(std::span<const core::Candidate> candidates) {
  return ListOf(candidates, [](const core::Candidate& candidate) {
    return json::object{{"component", core::Name(candidate.component)},
                        {"value", NumberOrNull(candidate.value)},
                        {"sigma", NumberOrNull(candidate.sigma)},
                        {"unit", core::Unit(candidate.component)},
                        {"bound", Bound(candidate.bound)},
                        {"score", NumberOrNull(candidate.score)},
                        {"margin", NumberOrNull(candidate.margin)},
                        {"probability", NumberOrNull(candidate.probability)}};
  });
}

json::array Path(std::span<const core::PathStep> path) {
  return ListOf(path, [](const core::PathStep& step) {
    return json::object{{"question", step.question},
                        {"answer", step.answer},
                        {"value", NumberOrNull(step.value)},
                        {"threshold", NumberOrNull(step.threshold)},
                        {"leads_to", step.leads_to},
                        {"components", ComponentNames(step.components)},
                        {"close", core::IsClose(step)}};
  });
}

json::array Detections(std::span<const core::Detection> detections) {
  return ListOf(detections, [](const core::Detection& one) {
    return json::object{{"detected_at_s", NumberOrNull(one.detected_at_s)},
                        {"onset_s", NumberOrNull(one.onset_s)},
                        {"detector", one.detector}};
  });
}

json::object Theta(const core::ContinuousTheta& theta) {
  json::object out;
  for (std::size_t i = 0; i < theta.size(); ++i) {
    out[kSiaNames[i]] = NumberOrNull(theta[i]);
  }
  return out;
}

json::array Inverse(std::span<const core::InverseSolution> solutions) {
  return ListOf(solutions, [](const core::InverseSolution& solution) {
    const double value = solution.exists ? solution.value : core::kAbsent;
    return json::object{{"component", core::Name(solution.component)},
                        {"value", NumberOrNull(value)},
                        {"unit", core::Unit(solution.component)},
                        {"mismatch", NumberOrNull(solution.mismatch)}};
  });
}

json::array Episodes(std::span<const core::FaultEpisode> episodes) {
  return ListOf(episodes, [](const core::FaultEpisode& episode) {
    json::object one = ToJson(episode.verdict);
    one["shape"] = episode.shape == core::FaultShape::kDrift ? "drift" : "abrupt";
    one["ended_at_s"] = NumberOrNull(episode.ended_at_s);
    return one;
  });
}

}  // namespace

json::array ComponentNames(std::span<const core::Component> components) {
  return ListOf(components, [](core::Component component) { return core::Name(component); });
}

json::object ToJson(const core::SpeedResponse& response) {
  const auto measured = [](const core::Measured& number) {
    return json::object{{"value", NumberOrNull(number.value)},
                        {"sigma", NumberOrNull(number.sigma)}};
  };
  return {{"gain_rpm_per_v", measured(response.gain)},
          {"time_constant_s", measured(response.time_constant)},
          {"friction_rpm", measured(response.friction)}};
}

json::object ToJson(const core::Verdict& verdict) {
  json::object out{{"verdict", core::Name(verdict.kind)},
                   {"detected_at_s", NumberOrNull(verdict.detected_at_s)},
                   {"onset_s", NumberOrNull(verdict.onset_s)},
                   {"detector", verdict.detector},
                   {"group", ComponentNames(verdict.group)},
                   {"candidates", Candidates(verdict.candidates)},
                   {"path", Path(verdict.path)},
                   {"settled", verdict.settled},
                   {"reason", verdict.reason}};
  if (const core::PathOutcome outcome = core::ComparePath(verdict);
      outcome != core::PathOutcome::kNothing) {
    out["path_outcome"] = core::Name(outcome);
  }
  if (!verdict.further.empty()) out["further"] = Detections(verdict.further);
  if (verdict.sensor) {
    out["sensor"] = json::object{
        {"channel", verdict.sensor->channel},
        {"change", core::SensorChange::kKindNames[static_cast<int>(verdict.sensor->kind)]},
        {"value", NumberOrNull(verdict.sensor->value)},
        {"sigma", NumberOrNull(verdict.sensor->sigma)}};
  }
  if (verdict.friction) {
    out["friction"] = json::object{{"before_nm", verdict.friction->before_nm},
                                   {"after_nm", verdict.friction->after_nm},
                                   {"sigma_nm", verdict.friction->sigma_nm}};
  }
  if (verdict.response) {
    out["response"] = json::object{{"before", ToJson(verdict.response->before)},
                                   {"after", ToJson(verdict.response->after)}};
  }
  return out;
}

json::object ToJson(core::EstimatorId id, const core::Estimate<3>& made) {
  const core::Estimate<3> estimate = core::Shown(made);
  const core::EstimatorShape& shape = core::kEstimatorShapes[static_cast<std::size_t>(id)];
  return {{"names", ListOf(shape.integral_samples == 0 ? kSwaNames : kSiaNames)},
          {"theta", NumbersOrNull(estimate.theta)},
          {"sigma", NumbersOrNull(estimate.sigma)},
          {"condition", NumberOrNull(estimate.condition)},
          {"status", core::Name(estimate.status)},
          {"age", estimate.age_samples}};
}

json::object ToJson(const core::PaperMethods& paper) {
  json::object full_values;
  for (std::size_t i = 0; i < paper.full_jacobian_values.size(); ++i) {
    full_values[core::Name(paper.exact[i].component)] = NumberOrNull(paper.full_jacobian_values[i]);
  }
  return {{"nominal", Theta(paper.nominal)},
          {"estimate", Theta(paper.estimate)},
          {"band", Theta(paper.band)},
          {"path", Path(paper.path)},
          {"named", ComponentNames(paper.named)},
          {"single_column", Inverse(paper.single_column)},
          {"exact", Inverse(paper.exact)},
          {"full_jacobian",
           json::object{{"rank", paper.full_jacobian_rank},
                        {"condition", NumberOrNull(paper.full_jacobian_condition)},
                        {"pseudo_inverse_values", std::move(full_values)}}}};
}

json::object ToJson(const core::Diagnosis& diagnosis, const core::Bench& bench) {
  json::object out = ToJson(diagnosis.verdict);
  out["calibration"] = diagnosis.calibration ? json::value(ToJson(*diagnosis.calibration, bench))
                                             : json::value(nullptr);
  if (diagnosis.calibration_refusal) {
    out["calibration_refusal"] = json::object{{"check", diagnosis.calibration_refusal->field},
                                              {"message", diagnosis.calibration_refusal->message}};
  }
  json::object estimates;
  for (std::size_t i = 0; i < core::kEstimatorCount; ++i) {
    json::object one = ToJson(static_cast<core::EstimatorId>(i), diagnosis.estimates[i]);
    one["nominal"] = NumbersOrNull(diagnosis.nominal_estimates[i]);
    estimates[core::kEstimatorShapes[i].name] = std::move(one);
  }
  out["estimates"] = std::move(estimates);
  json::object fits;
  for (const core::FitPercent& fit : diagnosis.fit_percent) {
    fits[fit.model] = NumberOrNull(fit.percent);
  }
  out["fit_percent"] = std::move(fits);
  out["paper"] = ToJson(diagnosis.paper);
  out["episodes"] = Episodes(diagnosis.episodes);
  return out;
}

}  // namespace faultlab::server
