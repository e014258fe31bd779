#include <algorithm>
#include <cmath>
#include <sstream>
#include <string_view>

#include "core/filter/speed_response.h"
#include "core/types/number_text.h"
#include "server/diagnosis_json/diagnosis_json.h"

namespace faultlab::server {
namespace {

constexpr int kIndent = 14;

std::string Digits(double value, int digits) {
  if (!std::isfinite(value)) {
    return "unknown";
  }
  return core::Format("%.*g", digits, value);
}

/// Of the first channel that was used.
std::string NoiseText(const core::Calibration& calibration) {
  constexpr double kMilli = 1e3;
  if (calibration.used_um) return Digits(kMilli * calibration.um_noise_v, 3) + " mV";
  if (calibration.used_ia) return Digits(kMilli * calibration.ia_noise_a, 3) + " mA";
  return Digits(calibration.n_noise_rpm, 3) + " rpm";
}

std::string Seconds(double value) {
  return core::Format("%.2f s", value);
}

std::string Label(std::string_view label) {
  std::string out = "  " + std::string(label);
  out.resize(kIndent, ' ');
  return out;
}

/// "R1 = 99.8 +- 0.4 ohm", "J < 1e-07 kg m^2".
std::string CandidateText(const core::Candidate& candidate) {
  std::string text(core::Name(candidate.component));
  if (candidate.bound != 0) {
    text += std::string(" ") + candidate.bound + " " + Digits(candidate.value, 4);
  } else {
    text += " = " + Digits(candidate.value, 4) + " +- " + Digits(candidate.sigma, 2);
  }
  return text + " " + std::string(core::Unit(candidate.component));
}

std::string Joined(const std::vector<core::Component>& components) {
  std::string text;
  for (const core::Component component : components) {
    text += (text.empty() ? "" : "/") + std::string(core::Name(component));
  }
  return text;
}

bool InGroup(const core::Verdict& verdict, core::Component component) {
  return std::ranges::find(verdict.group, component) != verdict.group.end();
}

void AppendDetections(std::ostringstream& out, const core::Verdict& verdict) {
  std::string_view label = "detected";
  for (const core::Detection& one : core::DetectionsOf(verdict)) {
    out << Label(label) << "at " << Seconds(one.detected_at_s);
    if (one.onset_s) {
      out << ", began at about " << Seconds(*one.onset_s);
    }
    out << (one.detector.empty() ? "" : " (" + one.detector + ")") << '\n';
    label = "again";
  }
}

/// "gain 54.31 +- 0.12 rpm/V, time constant 63.4 +- 0.5 ms, friction 14.2 +- 0.6 rpm"
std::string ResponseText(const core::SpeedResponse& response) {
  constexpr double kMilli = 1e3;
  const auto with_error = [](const core::Measured& number, double factor) {
    return Digits(factor * number.value, 4) + " +- " + Digits(factor * number.sigma, 2);
  };
  return "gain " + with_error(response.gain, 1.0) + " rpm/V, time constant " +
         with_error(response.time_constant, kMilli) + " ms, friction " +
         with_error(response.friction, 1.0) + " rpm";
}

/// "97 %", "over 99.9 %"
std::string PercentText(double probability) {
  if (probability > 0.999) return "over 99.9 %";
  return Digits(100.0 * probability, probability > 0.99 ? 3 : 2) + " %";
}

void AppendVerdict(std::ostringstream& out, const core::Verdict& verdict) {
  AppendDetections(out, verdict);
  if (verdict.kind == core::VerdictKind::kNominal && verdict.response) {
    out << Label("response") << ResponseText(verdict.response->after) << '\n';
  }
  if (verdict.kind == core::VerdictKind::kFault) {
    out << Label("component") << Joined(verdict.group)
        << (verdict.group.size() > 1 ? "  (these sensors cannot tell them apart)" : "") << '\n';
    const double certainty = core::ProbabilityOf(verdict);
    if (std::isfinite(certainty)) out << Label("certainty") << PercentText(certainty) << '\n';
    const core::Candidate* runner_up = nullptr;
    for (const core::Candidate& candidate : verdict.candidates) {
      if (InGroup(verdict, candidate.component)) {
        out << Label("value") << CandidateText(candidate) << '\n';
      } else if (runner_up == nullptr) {
        runner_up = &candidate;
      }
    }
    if (runner_up != nullptr) {
      out << Label("runner-up") << CandidateText(*runner_up) << ", explains the record "
          << Digits(runner_up->margin, 3) << " worse (best "
          << Digits(verdict.candidates[0].score, 3) << ", 1 explains all)\n";
    }
  }
  if (verdict.kind == core::VerdictKind::kFault && verdict.response) {
    out << Label("before") << ResponseText(verdict.response->before) << '\n';
    out << Label("after") << ResponseText(verdict.response->after) << '\n';
  }
  if (!verdict.reason.empty()) {
    out << Label("reason") << verdict.reason << '\n';
  }
}

void AppendPath(std::ostringstream& out, const std::vector<core::PathStep>& path) {
  std::string_view label = "path";
  for (const core::PathStep& step : path) {
    out << Label(label) << step.question << (step.answer ? " yes" : " no") << " ("
        << Digits(step.value, 4) << ", limit " << Digits(step.threshold, 4) << ")";
    if (!step.leads_to.empty()) {
      out << " -> " << step.leads_to;
    }
    out << '\n';
    label = "";
  }
}

void AppendCalibration(std::ostringstream& out, const core::Diagnosis& diagnosis) {
  if (diagnosis.calibration_refusal &&
      diagnosis.calibration_refusal->message != diagnosis.verdict.reason) {
    out << Label("calibration") << diagnosis.calibration_refusal->message << '\n';
  }
  if (!diagnosis.calibration) {
    return;
  }
  const core::Calibration& calibration = *diagnosis.calibration;
  constexpr double kMilli = 1e3;
  out << Label("calibrated") << (calibration.dated.empty() ? "" : calibration.dated + ", ") << "on "
      << Seconds(calibration.from_s) << " to " << Seconds(calibration.to_s) << ": delay "
      << Digits(kMilli * calibration.delta_s, 3) << " ms, Mc "
      << Digits(kMilli * calibration.mc_nm, 3) << " +- "
      << Digits(kMilli * calibration.mc_sigma_nm, 1) << " mNm, noise " << NoiseText(calibration)
      << ", " << Digits(calibration.thresholds.false_alarms_per_day, 3) << " false alarm a day\n";
}

void AppendFits(std::ostringstream& out, const std::vector<core::FitPercent>& fits) {
  std::string text;
  for (const core::FitPercent& fit : fits) {
    if (std::isfinite(fit.percent)) {
      text += (text.empty() ? "" : ", ") + fit.model + ' ' + Digits(fit.percent, 4) + " %";
    }
  }
  if (!text.empty()) {
    out << Label("fit") << text << '\n';
  }
}

}  // namespace

std::string ToText(const core::Calibration& calibration, const std::string& name) {
  std::ostringstream out;
  out << name << ": calibrated on " << Seconds(calibration.from_s) << " to "
      << Seconds(calibration.to_s) << ", " << calibration.samples << " samples\n";
  if (!calibration.dated.empty()) {
    out << Label("dated") << calibration.dated << '\n';
  }
  constexpr double kPercent = 100.0;
  constexpr double kHeld = 1e-6;  // of the value: of the models, and no quantity of the rig
  for (const core::CalibratedQuantity& quantity : calibration.quantities) {
    if (quantity.sigma < kHeld * std::abs(quantity.value)) continue;
    out << Label(quantity.name) << Digits(quantity.value, 4) << " +- " << Digits(quantity.sigma, 2)
        << ' ' << quantity.unit;
    if (!quantity.from_data) {
      out << "  (these data do not show it: the data sheet's)";
    } else if (quantity.prior_value != 0.0 && quantity.name != "delta" && quantity.name != "Mc") {
      out << "  (data sheet " << Digits(quantity.prior_value, 4) << ", "
          << Digits(kPercent * (quantity.value / quantity.prior_value - 1.0), 2) << " % off)";
    }
    out << '\n';
  }
  if (calibration.nominal.structure->estimated == core::EstimatedChannel::kSpeed) {
    out << Label("response") << ResponseText(core::SpeedResponseOf(calibration)) << '\n';
  }
  constexpr double kMilli = 1e3;
  std::string noise;
  const auto add = [&noise](const std::string& channel) {
    noise += (noise.empty() ? "" : ", ") + channel;
  };
  if (calibration.used_um) add("um " + Digits(kMilli * calibration.um_noise_v, 3) + " mV");
  if (calibration.used_ia) add("ia " + Digits(kMilli * calibration.ia_noise_a, 3) + " mA");
  if (calibration.used_n) add("n " + Digits(calibration.n_noise_rpm, 3) + " rpm");
  out << Label("noise") << noise << '\n'
      << Label("alarms") << Digits(calibration.thresholds.false_alarms_per_day, 3)
      << " false one a day\n";
  for (const core::CalibrationCheck& check : calibration.checks) {
    out << Label("check") << check.name << ": " << check.sentence << '\n';
  }
  return out.str();
}

std::string ToText(const core::Diagnosis& diagnosis, const std::string& name) {
  std::ostringstream out;
  const core::Verdict& verdict = diagnosis.verdict;
  // The record has ended, so the calibration does not continue.
  const bool refused =
      verdict.kind == core::VerdictKind::kCalibrating && diagnosis.calibration_refusal.has_value();
  std::string kind(refused ? "no diagnosis" : core::Name(verdict.kind));
  for (char& letter : kind) {
    letter = letter == '_' ? ' ' : letter;
  }
  if (IsOutside(verdict))
    kind = verdict.sensor ? "sensor of " + verdict.sensor->channel : "friction";
  out << name << ": " << kind << '\n';
  AppendVerdict(out, verdict);
  if (diagnosis.episodes.size() > 1) {
    out << Label("episodes") << diagnosis.episodes.size() << ", the last one is shown above\n";
    for (const core::FaultEpisode& episode : diagnosis.episodes) {
      out << Label("") << Seconds(episode.verdict.detected_at_s.value_or(0.0)) << ": "
          << core::Name(episode.verdict.kind) << ' ' << Joined(episode.verdict.group);
      for (const core::Detection& again : episode.verdict.further) {
        out << ", again " << Seconds(again.detected_at_s);
      }
      if (episode.ended_at_s) {
        out << ", until " << Seconds(*episode.ended_at_s);
      }
      out << '\n';
    }
  }
  AppendPath(out, verdict.path.empty() ? diagnosis.paper.path : verdict.path);
  AppendCalibration(out, diagnosis);
  AppendFits(out, diagnosis.fit_percent);
  return out.str();
}

}  // namespace faultlab::server
