#include "server/api/diagnose_job.h"

#include <boost/json.hpp>

#include "server/api/json_reader.h"
#include "server/api/lab/handlers.h"
#include "server/diagnosis_json/diagnosis_json.h"
#include "server/plots/record_figure.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr double kSecondsMax = 100'000.0;
constexpr std::size_t kIdBytesMax = 64;
constexpr std::int64_t kIndexMax = 1'000'000'000;

core::Error OnRecording(core::Error error) {
  error.field = "/diagnose/recording";
  return error;
}

}  // namespace

core::Result<std::optional<DiagnoseJob>> ParseDiagnoseJob(const json::object& body) {
  using MaybeJob = std::optional<DiagnoseJob>;
  ObjectReader in(body, "");
  if (!in.Has("diagnose")) return MaybeJob{};
  const json::object* wanted = in.ObjectOrNull("diagnose");
  (void)in.TextOr("name", "", kIdBytesMax);
  if (auto error = in.Finish()) return *error;
  ObjectReader settings(*wanted, "/diagnose");
  DiagnoseJob job;
  core::DiagnoseOptions& options = job.options;
  job.recording = settings.Text("recording", kIdBytesMax);
  options.values = settings.WordOr("values", "none", {"none", "table2"}) == "table2"
                       ? core::ValuePrior::kTable2
                       : core::ValuePrior::kNone;
  options.channels = settings.WordOr("channels", "all", {"all", "um"}) == "um"
                         ? core::Channels::kUmOnly
                         : core::Channels::kAll;
  options.healthy_from_s = settings.NumberOr("healthy_from_s", 0.5, 0.0, kSecondsMax);
  options.healthy_to_s = settings.NumberOr("healthy_to_s", 5.0, 0.0, kSecondsMax);
  options.false_alarms_per_day = settings.NumberOr("false_alarms_per_day", 1.0, 1e-6, 1e6);
  options.motor_faults = settings.BooleanOr("motor_faults", true);
  if (options.healthy_to_s <= options.healthy_from_s) {
    settings.Refuse("healthy_to_s", "The healthy stretch ends after it begins.");
  }
  if (auto error = settings.Finish()) return *error;
  return MaybeJob{std::move(job)};
}

core::Status CheckDiagnoseJob(ApiContext& api, const Principal& who, const DiagnoseJob& job) {
  const auto record = api.store.Get(job.recording);
  if (!record) return OnRecording(record.error());
  const auto whose = RelationTo(api, who, record.value().owner);
  if (!whose) return OnRecording(whose.error());
  const core::Status allowed = Authorize(who, Operation::kReadRun, whose.value());
  if (!allowed.ok()) return OnRecording(allowed.error());
  if (record.value().state == RunState::kRunning) {
    return core::Error{
        core::ErrorCode::kConflict, "The recording is not finished.", "/diagnose/recording"};
  }
  return core::Done{};
}

core::Result<std::string> RunDiagnoseJob(ApiContext& api,
                                         const Principal& who,
                                         const DiagnoseJob& job) {
  const core::Status allowed = CheckDiagnoseJob(api, who, job);
  if (!allowed.ok()) return allowed.error();
  const auto record = api.store.Get(job.recording);
  if (!record) return OnRecording(record.error());
  const auto samples = api.store.LoadSamples(job.recording, 0, kIndexMax);
  if (!samples) return OnRecording(samples.error());
  core::DiagnoseOptions options = job.options;
  options.period_s = record.value().period_s;
  core::Diagnosis diagnosis = core::DiagnoseRecord(samples.value(), options);
  AddModelFits(samples.value(), options, diagnosis);
  json::object out = ToJson(diagnosis);
  out["recording"] = job.recording;
  out["samples"] = samples.value().size();
  out["period_s"] = options.period_s;
  return json::serialize(out);
}

}  // namespace faultlab::server
