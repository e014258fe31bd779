// The report of a run as PDF.
#include "server/report/report.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <charconv>
#include <cmath>
#include <string>

#include "core/diagnosis/diagnose_record.h"
#include "core/paper/paper_methods.h"
#include "core/plant/coefficients.h"
#include "server/api/run/file_names.h"
#include "server/api/run/handlers.h"
#include "server/experiment/plan_json.h"
#include "server/plots/figures.h"
#include "server/run/run_messages.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

json::value Parsed(const std::string& text) {
  boost::system::error_code ec;
  json::value value = json::parse(text, ec);
  return ec ? json::value(nullptr) : value;
}

std::string TextIn(const json::value& value, std::string_view name) {
  const json::object* object = value.if_object();
  const json::value* member = object == nullptr ? nullptr : object->if_contains(name);
  return member != nullptr && member->is_string() ? std::string(member->get_string())
                                                  : std::string();
}

/// The name of a person with the login, empty for a guest.
core::Result<std::string> NameOf(Accounts& accounts, const std::string& owner) {
  constexpr std::string_view kUser = "user:";
  if (!owner.starts_with(kUser)) return std::string();
  std::int64_t id = 0;
  std::from_chars(owner.data() + kUser.size(), owner.data() + owner.size(), id);
  const auto account = accounts.Get(id);
  if (!account && account.error().code == core::ErrorCode::kNotFound) return owner;
  if (!account) return account.error();
  const std::string& name = account.value().name;
  const std::string& login = account.value().login;
  return name.empty() || name == login ? login : name + " (" + login + ")";
}

/// "low_v", 2 -> "low 2 V"
std::string WithUnit(std::string_view name, double value) {
  constexpr std::array<std::array<std::string_view, 2>, 3> kUnits = {
      {{"_v", " V"}, {"_s", " s"}, {"_hz", " Hz"}}};
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  const std::string number(digits.data(), end.ptr);
  for (const auto& [suffix, unit] : kUnits) {
    if (!name.ends_with(suffix)) continue;
    name.remove_suffix(suffix.size());
    return std::string(name) + " " + number + std::string(unit);
  }
  return std::string(name) + " " + number;
}

/// "prbs: low 2 V, high 3 V, clock 0.01 s, order 10, seed 1"
std::string ExcitationText(const json::value& plan) {
  const json::object* object = plan.if_object();
  const json::value* found = object == nullptr ? nullptr : object->if_contains("excitation");
  const json::object* excitation = found == nullptr ? nullptr : found->if_object();
  if (excitation == nullptr) return {};
  std::string text = TextIn(*found, "kind");
  std::string separator = ": ";
  for (const auto& [name, value] : *excitation) {
    if (!value.is_number()) continue;
    text.append(separator).append(WithUnit(name, value.to_number<double>()));
    separator = ", ";
  }
  return text;
}

/// What the rig did with each change of a component: the same events as in the run's JSON.
std::vector<ReportFault> FaultsOf(std::span<const RecordedEvent> events,
                                  const core::Bench& bench,
                                  double period_s) {
  std::vector<ReportFault> faults;
  for (const RecordedEvent& recorded : events) {
    const auto event = ToRigEvent(recorded, bench);
    if (!event || !event->component.exists()) continue;
    using enum hardware::RigEventKind;
    if (event->kind == kFaultCommanded) {
      faults.push_back({static_cast<double>(event->index) * period_s,
                        event->index,
                        event->component,
                        event->value,
                        ReportFault::Said::kNothing});
      continue;
    }
    if (event->kind != kRelayConfirmed && event->kind != kRefused) continue;
    // The oldest command of this component that has no answer yet.
    auto asked = std::find_if(faults.begin(), faults.end(), [&](const ReportFault& fault) {
      return fault.said == ReportFault::Said::kNothing && fault.component == event->component &&
             (event->kind == kRefused || fault.value == event->value);
    });
    if (asked == faults.end()) asked = faults.insert(faults.end(), ReportFault{});
    *asked = {
        static_cast<double>(event->index) * period_s,
        event->index,
        event->component,
        event->kind == kRefused && asked->component.exists() ? asked->value : event->value,
        event->kind == kRefused ? ReportFault::Said::kRefused : ReportFault::Said::kConfirmed};
  }
  return faults;
}

/// The healthy time, and the time of the first fault.
struct Stretches {
  double onset_s = INFINITY;
  double end_s = INFINITY;  ///< of the fault: the next change
  std::optional<core::Fault> fault;
};

Stretches StretchesOf(std::span<const ReportFault> faults, const core::Verdict& verdict) {
  Stretches out;
  for (const ReportFault& fault : faults) {
    if (fault.said != ReportFault::Said::kConfirmed) continue;
    if (!out.fault && fault.value == fault.component.info().nominal) continue;
    if (out.fault) {
      out.end_s = fault.t_s;
      break;
    }
    out.fault = core::Fault{.component = fault.component, .value = fault.value};
    out.onset_s = fault.t_s;
  }
  if (out.fault) return out;
  if (verdict.onset_s) out.onset_s = *verdict.onset_s;
  const bool sized = verdict.kind == core::VerdictKind::kFault && !verdict.candidates.empty() &&
                     verdict.candidates.front().bound == 0;
  if (sized) {
    const core::Candidate& best = verdict.candidates.front();
    out.fault = core::Fault{.component = best.component, .value = best.value};
  }
  return out;
}

struct Mean {
  double sum = 0.0;
  int count = 0;
  void Add(double value) {
    sum += value;
    ++count;
  }
  std::optional<double> value() const {
    return count > 0 ? std::optional(sum / count) : std::nullopt;
  }
};

/// What the calibrated model of the rig predicts for the fault, {b0, b1, a1} and {b0d, b1d, a1d}.
std::optional<std::array<core::ContinuousTheta, 2>> ModelOf(
    const Review& review, const std::optional<core::Fault>& fault) {
  if (!fault || !std::isfinite(fault->value) || fault->value <= 0.0) return std::nullopt;
  const auto& calibration = review.diagnosis.calibration;
  const core::DiagnosisOptions& options = review.recording.options;
  core::PlantParameters plant = calibration ? calibration->nominal : options.nominal;
  plant.Set(fault->component, fault->value);
  const core::ContinuousTheta theta =
      core::FirstOrderTheta(plant, calibration ? calibration->gain_factor : 1.0);
  const double delta_s = calibration ? calibration->delta_s : options.bench->delta_s;
  const bool sampled = theta[2] > 0.0 && delta_s >= 0.0 && delta_s < options.period_s;
  if (!sampled) return std::nullopt;
  const core::DiscreteCoefficients discrete =
      core::Discretise({.b0 = theta[0], .b1 = theta[1], .a1 = theta[2]}, options.period_s, delta_s);
  return std::array<core::ContinuousTheta, 2>{
      theta, core::ContinuousTheta{discrete.b0d, discrete.b1d, discrete.a1d}};
}

/// Means over the healthy seconds before the fault, and from when the estimator has settled.
std::vector<ReportEstimates> EstimatesOf(const Review& review, const Stretches& stretches) {
  constexpr std::array<core::EstimatorId, 2> kShown = {core::EstimatorId::kSwa100,
                                                       core::EstimatorId::kSia100x20};
  constexpr double kBeforeS = 5.0;
  constexpr double kBeforeSamples = 100.0;
  constexpr double kFilledS = 0.5;
  constexpr std::array<std::string_view, 3> kNames = {"b0", "b1", "a1"};
  const core::DiagnosisOptions& options = review.recording.options;
  const double period_s = options.period_s;
  std::array<std::array<Mean, 3>, kShown.size()> before;
  std::array<std::array<Mean, 3>, kShown.size()> after;
  std::array<double, kShown.size()> settles_s{};
  for (std::size_t i = 0; i < kShown.size(); ++i) {
    const core::EstimatorShape& shape = core::kEstimatorShapes[static_cast<std::size_t>(kShown[i])];
    settles_s[i] = (shape.window_samples + std::max(0, shape.integral_samples - 1)) * period_s;
  }
  const double before_s = std::max(kBeforeS, kBeforeSamples * period_s);
  core::ReplayEstimates(review.recording.samples, options, [&](const core::Frame& frame) {
    const double t_s = frame.sample.t_s;
    for (std::size_t i = 0; i < kShown.size(); ++i) {
      const double healthy_from_s =
          std::max(settles_s[i] + kFilledS,
                   std::isfinite(stretches.onset_s) ? stretches.onset_s - before_s : 0.0);
      const bool healthy = t_s >= healthy_from_s && t_s < stretches.onset_s;
      const bool faulty = t_s > stretches.onset_s + settles_s[i] && t_s < stretches.end_s;
      if (!healthy && !faulty) continue;
      const core::Estimate<3>& estimate = frame.estimates[static_cast<std::size_t>(kShown[i])];
      for (std::size_t p = 0; p < kNames.size(); ++p) {
        const bool usable =
            IsDrawable(estimate.status, estimate.age_samples, estimate.sigma, static_cast<int>(p));
        if (usable) (healthy ? before : after)[i][p].Add(estimate.theta[p]);
      }
    }
  });
  const auto model = ModelOf(review, stretches.fault);
  std::vector<ReportEstimates> out;
  for (std::size_t i = 0; i < kShown.size(); ++i) {
    const core::EstimatorShape& shape = core::kEstimatorShapes[static_cast<std::size_t>(kShown[i])];
    const bool swa = shape.integral_samples == 0;
    ReportEstimates one;
    one.title =
        (swa ? "SWA, " : "SIA, ") + WindowName(shape.window_samples, shape.integral_samples);
    for (std::size_t p = 0; p < kNames.size(); ++p) {
      one.rows.push_back({std::string(kNames[p]) + (swa ? "d" : ""),
                          before[i][p].value(),
                          after[i][p].value(),
                          model ? std::optional((*model)[swa ? 1 : 0][p]) : std::nullopt});
    }
    out.push_back(std::move(one));
  }
  return out;
}

std::string CsvSha256(const Recording& recording, std::span<const RecordedEvent> events) {
  crypto_hash_sha256_state state;
  crypto_hash_sha256_init(&state);
  FormatCsvOf(recording, events, [&state](std::string_view piece) {
    crypto_hash_sha256_update(
        &state, reinterpret_cast<const unsigned char*>(piece.data()), piece.size());
  });
  std::array<unsigned char, crypto_hash_sha256_BYTES> hash;
  crypto_hash_sha256_final(&state, hash.data());
  std::array<char, 2 * crypto_hash_sha256_BYTES + 1> hex;
  sodium_bin2hex(hex.data(), hex.size(), hash.data(), hash.size());
  return hex.data();
}

}  // namespace

core::Result<HttpResponse> GetReport(RunApi& api, const ApiRequest& request) {
  const core::Status query = OnlyQuery(request.http, {"language"});
  if (!query.ok()) return query.error();
  const auto language = ParseLanguage(request.http.Query("language").value_or("en"));
  if (!language) {
    return core::Error{core::ErrorCode::kInvalid, "The language is en or sr.", "language"};
  }
  if (request.run.state == RunState::kRunning) {
    return core::Error{core::ErrorCode::kConflict,
                       "The report is made when the run has ended; this one goes on.",
                       ""};
  }
  // First, because it repairs what a crash has cut.
  const auto diagnosis = api.recordings.DiagnosisText(request.run);
  if (!diagnosis) return diagnosis.error();
  const auto review = api.recordings.ReviewOf(request.run);
  if (!review) return review.error();
  const auto events = api.recordings.Events(request.run);
  if (!events) return events.error();
  auto made_by = NameOf(api.accounts, request.run.owner);
  if (!made_by) return made_by.error();
  const Recording& recording = review.value().recording;
  const RunRecord& record = recording.record;
  const json::value plan = Parsed(record.plan_json);

  RunReport report;
  report.id = record.id;
  report.name = record.name;
  report.made_by = std::move(made_by).value();
  report.began_at = Iso8601(record.created_at);
  if (record.ended_at) report.ended_at = Iso8601(*record.ended_at);
  report.state = Name(record.state);
  report.rig = record.rig;
  report.bench = recording.options.bench;
  report.samples = static_cast<std::int64_t>(recording.samples.size());
  report.period_s = record.period_s;
  report.excitation = ExcitationText(plan);
  report.replay_of = TextIn(plan, "recording");
  report.faults = FaultsOf(events.value(), *report.bench, record.period_s);
  report.diagnosis = review.value().diagnosis;
  const json::value told = Parsed(diagnosis.value());
  if (const json::object* object = told.if_object()) {
    const json::value* refusal = object->if_contains("calibration_refusal");
    if (refusal != nullptr) report.calibration_refusal = TextIn(*refusal, "message");
  }
  const Stretches stretches = StretchesOf(report.faults, report.diagnosis.verdict);
  report.estimates = EstimatesOf(review.value(), stretches);
  report.modelled = stretches.fault;
  report.figures.assign(std::begin(kFigureNames), std::end(kFigureNames));
  report.figure = [&review](const std::string& name) {
    return Recordings::FigureOf(review.value(), name, "");
  };
  report.version = FAULTLAB_VERSION;
  report.csv_sha256 = CsvSha256(recording, events.value());
  if (!api.public_url.empty()) report.address = api.public_url + "/runs/" + record.id;

  auto pdf = ReportPdf(report, *language);
  if (!pdf) return pdf.error();
  auto out = api.MakeSpool();
  out->Append(pdf.value());
  auto response = Spooled(std::move(out), "application/pdf");
  if (!response) return response;
  response.value().headers.emplace_back(
      "Content-Disposition", ContentDisposition("inline", FileNameOf(record, "report", "pdf")));
  return response;
}

}  // namespace faultlab::server
