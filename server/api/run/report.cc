// The report of a run as PDF.
#include "server/report/report.h"
#include "server/json/kept_json.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <string>

#include "core/types/number_text.h"
#include "server/api/run/before_after.h"
#include "server/api/run/file_names.h"
#include "server/api/run/handlers.h"
#include "server/api/run/truth.h"
#include "server/experiment/control_account.h"
#include "server/experiment/plan_json.h"
#include "server/plots/figures.h"
#include "server/run/run_messages.h"
#include "server/storage/owner_key.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::size_t kChangesInReport = 3;

/// The name of a person with the login, empty for a guest.
core::Result<std::string> NameOf(Accounts& accounts, const std::string& owner) {
  const std::optional<std::int64_t> id = AccountOfOwner(owner);
  if (!id) return std::string();
  const auto account = accounts.Get(*id);
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
  const std::string number = core::Shortest(value);
  for (const auto& [suffix, unit] : kUnits) {
    if (!name.ends_with(suffix)) continue;
    name.remove_suffix(suffix.size());
    return std::string(name) + " " + number + std::string(unit);
  }
  return std::string(name) + " " + number;
}

/// "PRBS: low 2 V, high 3 V, clock 0.01 s, order 10, seed 1"
std::string ExcitationText(const json::value& plan) {
  const json::value* found = MemberIn(plan, "excitation");
  const json::object* excitation = found == nullptr ? nullptr : found->if_object();
  if (excitation == nullptr) return {};
  std::string text = TextIn(*found, "kind");
  if (text == "prbs") text = "PRBS";
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
    auto asked = std::ranges::find_if(faults, [&](const ReportFault& fault) {
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

ReportControl ControlOf(const ControlAccount& account, const Review& review) {
  const core::SpeedReference& reference = account.planned.wanted.reference;
  const auto judged =
      [&](std::span<const core::Sample> samples) -> std::optional<ReportControl::Judged> {
    const auto quality = QualityOf(account, samples);
    if (!quality) return std::nullopt;
    return ReportControl::Judged{static_cast<double>(account.judged_from) * account.period_s,
                                 quality->iae_rad,
                                 quality->steady_error_rad_s / account.rad_per_s};
  };
  ReportControl control{.shape = std::string(core::Name(reference.shape)),
                        .low_rpm = reference.low_rad_s / account.rad_per_s,
                        .high_rpm = reference.high_rad_s / account.rad_per_s,
                        .hold_s = reference.hold_s,
                        .from_s = account.planned.from_s,
                        .made_up = {},
                        .judged = judged(review.recording.samples),
                        .alone = {}};
  for (const Compensation& each : account.compensations) {
    control.made_up.push_back({each.t_s, each.component, each.value});
  }
  const auto without = control.judged ? WithoutDiagnosis(account, review) : std::nullopt;
  if (without) control.alone = judged(*without);
  return control;
}

std::string CsvSha256(const Review& review) {
  crypto_hash_sha256_state state;
  crypto_hash_sha256_init(&state);
  FormatCsvOf(review.recording, review.events, review.story, [&state](std::string_view piece) {
    crypto_hash_sha256_update(
        &state, reinterpret_cast<const unsigned char*>(piece.data()), piece.size());
  });
  std::array<unsigned char, crypto_hash_sha256_BYTES> hash;
  crypto_hash_sha256_final(&state, hash.data());
  std::array<char, 2 * crypto_hash_sha256_BYTES + 1> hex;
  sodium_bin2hex(hex.data(), hex.size(), hash.data(), hash.size());
  return hex.data();
}

core::Result<HttpResponse> GetReport(Api& api, const ApiRequest& request) {
  const auto language = ParseLanguage(request.http.Query("language").value_or("en"));
  if (!language) {
    return core::Refuse(
        "word_unknown", "language", {{"member", "language"}, {"words", "en, sr, sr-Cyrl"}});
  }
  if (request.run.state == RunState::kRunning) {
    return core::Refuse("report_too_early");
  }
  // First, because it repairs what a crash has cut.
  TRY(const auto diagnosis, api.recordings.DiagnosisText(request.run));
  TRY(const auto run, RunForFile(request));
  TRY(const auto review, api.recordings.ReviewOf(run));
  const std::vector<RecordedEvent>& events = review.events;
  TRY(auto made_by, NameOf(api.accounts, request.run.owner));
  const Recording& recording = review.recording;
  const RunRecord& record = recording.record;
  const json::value plan = ParsedOr(record.plan_json);

  RunReport report;
  report.id = record.id;
  report.name = record.name;
  report.made_by = std::move(made_by);
  report.began_at = Iso8601(record.created_at);
  if (record.ended_at) report.ended_at = Iso8601(*record.ended_at);
  report.state = Name(record.state);
  report.rig = record.rig;
  report.bench = recording.options.bench;
  report.samples = static_cast<std::int64_t>(recording.samples.size());
  report.period_s = record.period_s;
  report.excitation = ExcitationText(plan);
  if (const auto account = AccountOf(review)) report.control = ControlOf(*account, review);
  report.replay_of = TextIn(plan, "recording");
  report.faults = FaultsOf(events, *report.bench, record.period_s);
  report.sealed = IsSealed(record.plan_json);
  report.diagnosis = review.diagnosis;
  report.story = review.story;
  const json::value told = ParsedOr(diagnosis);
  if (const json::value* refusal = MemberIn(told, "calibration_refusal")) {
    report.calibration_refusal = TextIn(*refusal, "message");
  }
  report.changes = EstimatesAround(review, kChangesInReport);
  report.figures.assign(std::begin(kFigureNames), std::begin(kFigureNames) + kFiguresOfReport);
  report.figure = [&review](const std::string& name) {
    return Recordings::FigureOf(review, name, "");
  };
  report.version = FAULTLAB_VERSION;
  report.csv_sha256 = CsvSha256(review);
  if (!api.public_url.empty()) report.address = api.public_url + "/runs/" + record.id;

  TRY(auto pdf, ReportPdf(report, *language));
  auto out = api.MakeSpool();
  out->Append(pdf);
  TRY(auto response, Spooled(std::move(out), "application/pdf"));
  response.headers.emplace_back("Content-Disposition",
                                ContentDisposition("inline", FileNameOf(record, "report", "pdf")));
  return response;
}

}  // namespace

std::span<const ApiRoute> ReportRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "runs/{id}/report.pdf", kReadRun, kRun, GetReport, kNoBody, kTransfer}.Takes(
          "language truth"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
