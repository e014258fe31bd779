#include "server/experiment/diagnosis_request.h"

#include <boost/json.hpp>

#include "core/diagnosis/diagnose_record.h"
#include "server/diagnosis_json/diagnosis_json.h"
#include "server/json/json_reader.h"
#include "server/plots/record_figure.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr const char* kRecordingField = "/diagnose/recording";

core::Error OnRecording(core::Error error) {
  error.field = kRecordingField;
  return error;
}

core::Result<RunRecord> Find(Recordings& recordings,
                             const Principal& who,
                             const DiagnosisRequest& request) {
  return FinishedRecording(recordings, who, request.recording, kRecordingField);
}

/// The request for a record of this bench: what it leaves out is as usual there.
core::Result<core::DiagnosisOptions> DiagnosisOptionsOf(const DiagnosisRequest& request,
                                                        const core::Bench& bench,
                                                        double period_s,
                                                        double first_s) {
  if (request.channels == core::Channels::kUmOnly && !bench.um.exists) {
    return core::Refuse("channel_missing", "/diagnose/channels", {{"bench", bench.name}});
  }
  core::DiagnosisOptions options = core::OptionsOf(bench, period_s);
  core::CountFrom(first_s, options);
  options.channels = request.channels;
  options.values = request.values;
  options.healthy_from_s = request.healthy_from_s.value_or(options.healthy_from_s);
  options.healthy_to_s = request.healthy_to_s.value_or(options.healthy_to_s);
  options.false_alarms_per_day = request.false_alarms_per_day;
  options.motor_faults = request.motor_faults;
  if (options.healthy_to_s <= options.healthy_from_s) {
    return core::Refuse("stretch_backwards", "/diagnose/healthy_to_s");
  }
  return options;
}

}  // namespace

core::Result<DiagnosisRequest> ParseDiagnosisRequest(const json::object& body) {
  ObjectReader in(body, "");
  const json::object* wanted = in.ObjectOrNull("diagnose");
  (void)in.TextOr("name", "", kRecordingIdBytesMax);
  if (auto error = in.Finish()) return *error;
  if (wanted == nullptr) {
    return core::Refuse("member_missing", "/diagnose", {{"member", "diagnose"}});
  }
  ObjectReader settings(*wanted, "/diagnose");
  DiagnosisRequest request;
  request.recording = settings.Text("recording", kRecordingIdBytesMax);
  request.values = settings.WordOr("values", "none", {"none", "table2"}) == "table2"
                       ? core::ValuePrior::kTable2
                       : core::ValuePrior::kNone;
  request.channels = settings.WordOr("channels", "all", {"all", "um"}) == "um"
                         ? core::Channels::kUmOnly
                         : core::Channels::kAll;
  const auto seconds = [&settings](const char* name, std::optional<double>& to) {
    if (settings.Has(name)) to = settings.NumberOr(name, 0.0, 0.0, kRecordingSecondsMax);
  };
  seconds("healthy_from_s", request.healthy_from_s);
  seconds("healthy_to_s", request.healthy_to_s);
  request.false_alarms_per_day = settings.NumberOr("false_alarms_per_day", 1.0, 1e-6, 1e6);
  request.motor_faults = settings.BooleanOr("motor_faults", true);
  if (auto error = settings.Finish()) return *error;
  return request;
}

core::Status CheckDiagnosis(Recordings& recordings,
                            const Principal& who,
                            const DiagnosisRequest& request) {
  TRY(const auto record, Find(recordings, who, request));
  const auto stored = recordings.OptionsFor(record);
  if (!stored) return OnRecording(stored.error());
  const auto options = DiagnosisOptionsOf(request, *stored.value().bench, record.period_s, 0.0);
  return options.ok() ? core::Status(core::Done{}) : options.error();
}

core::Result<std::string> Diagnose(Recordings& recordings,
                                   const Principal& who,
                                   const DiagnosisRequest& request) {
  TRY(auto record, Find(recordings, who, request));
  const auto recording =
      recordings.Load(std::move(record), 0, kSampleIndexMax, LongTurn::For::kJob);
  if (!recording) return OnRecording(recording.error());
  const std::vector<core::Sample>& samples = recording.value().samples;
  const core::Bench& bench = *recording.value().options.bench;
  TRY(const auto options,
      DiagnosisOptionsOf(request,
                         bench,
                         recording.value().record.period_s,
                         samples.empty() ? 0.0 : samples.front().t_s));
  core::Diagnosis diagnosis = core::DiagnoseRecord(samples, options);
  AddModelFits(samples, options, diagnosis);
  json::object out = ToJson(diagnosis, bench);
  out["recording"] = request.recording;
  out["samples"] = samples.size();
  out["period_s"] = options.period_s;
  return json::serialize(out);
}

}  // namespace faultlab::server
