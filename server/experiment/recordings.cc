#include "server/experiment/recordings.h"

#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <utility>

#include "core/diagnosis/diagnose_record.h"
#include "server/diagnosis_json/calibration_json.h"
#include "server/diagnosis_json/diagnosis_json.h"
#include "server/diagnosis_json/options_json.h"
#include "server/experiment/control_json.h"
#include "server/experiment/plan_json.h"
#include "server/json/kept_json.h"
#include "server/plots/record_figure.h"
#include "server/storage/ids.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::size_t kSamplesPerChunk = 1000;

std::string TextOf(const core::Diagnosis& diagnosis,
                   const Recording& recording,
                   std::span<const std::string> channels = {}) {
  json::object object = ToJson(diagnosis, *recording.options.bench);
  object["samples"] = recording.samples.size();
  object["period_s"] = recording.record.period_s;
  if (!channels.empty()) object["channels"] = json::array(channels.begin(), channels.end());
  return json::serialize(object);
}

/// What the rig was told to change, and what it confirmed.
bool TellsAFault(const RecordedEvent& event) {
  constexpr std::array<std::string_view, 5> kTelling = {
      "fault_commanded", "relay_confirmed", "refused", "change_waits", "change_dropped"};
  return std::ranges::find(kTelling, event.kind) != kTelling.end();
}

void LeaveOutSealed(const RunRecord& record, std::vector<RecordedEvent>& events) {
  if (!IsSealed(record.plan_json)) return;
  std::erase_if(events, [](const RecordedEvent& event) { return TellsAFault(event); });
}

std::string WordOf(const core::Diagnosis& diagnosis) {
  return std::string(core::Name(diagnosis.verdict.kind));
}

}  // namespace

core::Result<core::DiagnosisOptions> OptionsOf(const RunRecord& record, const core::Bench& bench) {
  core::DiagnosisOptions options = core::OptionsOf(bench);
  if (!record.options_json.empty()) {
    TRY(options, ParseOptions(record.options_json, bench));
  }
  options.period_s = record.period_s;  // to the last bit: the estimates depend on it
  return options;
}

void LearnNothing(core::DiagnosisOptions& options) {
  constexpr double kNeverS = 1e9;
  options.calibration.reset();
  options.healthy_from_s = options.healthy_to_s = kNeverS;
}

std::string LoopText(std::span<const RecordedEvent> events) {
  for (const RecordedEvent& event : events) {
    if (event.kind != "finished" && event.kind != "stopped") continue;
    const json::value parsed = ParsedOr(event.json);
    if (const json::value* loop = MemberIn(parsed, "loop")) return json::serialize(*loop);
  }
  return "null";
}

core::Result<RunRecord> Recordings::Opened(RunRecord record) {
  if (!open_due_ || !IsSealed(record.plan_json)) return record;
  open_due_(record);
  return store_.Get(record.id);
}

core::Result<RunRecord> Recordings::Find(const Principal& who,
                                         const std::string& id,
                                         Operation operation) {
  TRY(auto record, store_.Get(id));
  TRY(const auto whose, accounts_.RelationTo(who, record.owner, record.created_at));
  const core::Status allowed = Authorize(who, operation, whose);
  if (allowed.ok()) return Opened(std::move(record));
  const std::int64_t trial = TrialOf(record.plan_json);
  const bool shared = trial != 0 && operation == Operation::kReadRun && who.user_id != 0 &&
                      is_of_ && is_of_(trial, who.user_id) &&
                      Authorize(who, operation, Ownership::kOwn).ok();
  if (!shared) return allowed.error();
  return Opened(std::move(record));
}

core::Result<RunRecord> FinishedRecording(Recordings& recordings,
                                          const Principal& who,
                                          const std::string& id,
                                          const std::string& field) {
  auto record = recordings.Find(who, id, Operation::kReadRun);
  core::Error error = core::Refuse("recording_unfinished", field);
  if (record && IsSealed(record.value().plan_json)) {
    error = core::Refuse("run_sealed");
    error.field = field;
    return error;
  }
  if (record && record.value().state != RunState::kRunning) return record;
  if (!record) error = record.error();
  error.field = field;
  return error;
}

core::Result<core::DiagnosisOptions> Recordings::OptionsFor(const RunRecord& record) {
  TRY(const auto bench, benches_.OfRecording(record.bench));
  return OptionsOf(record, *bench);
}

core::Result<Recording> Recordings::Load(RunRecord record,
                                         std::int64_t from,
                                         std::int64_t to,
                                         LongTurn::For whom) {
  const std::int64_t samples = std::min(record.samples, to) - from;
  TRY(auto turn, long_turn_.ForSamples(samples, whom));
  return LoadWith(std::move(record), from, to, std::move(turn));
}

core::Result<Recording> Recordings::LoadWith(RunRecord record,
                                             std::int64_t from,
                                             std::int64_t to,
                                             LongTurn::Hold turn) {
  TRY(auto options, OptionsFor(record));
  TRY(auto samples, store_.LoadSamples(record.id, from, to));
  return Recording{std::move(record), std::move(options), std::move(samples), std::move(turn)};
}

core::Result<std::vector<RecordedEvent>> Recordings::Events(const RunRecord& record) {
  core::Result<std::vector<RecordedEvent>> events = std::vector<RecordedEvent>{};
  const auto live =
      record.state == RunState::kRunning ? runs_.Find(record.id) : std::optional<RunSnapshot>{};
  events = live ? live->events : store_.LoadEvents(record.id);
  if (events) LeaveOutSealed(record, events.value());
  return events;
}

RunStory Recordings::StoryOf(const RunRecord& record,
                             std::vector<RecordedEvent> events,
                             Missing missing) {
  const auto bench = benches_.OfRecording(record.bench);
  if (!bench) return {};
  LeaveOutSealed(record, events);
  core::Diagnosis found;
  const auto live =
      record.state == RunState::kRunning ? runs_.Find(record.id) : std::optional<RunSnapshot>{};
  std::string text = record.diagnosis_json;
  const bool lacks =
      text.empty() && record.state != RunState::kRunning && !IsSealed(record.plan_json);
  if (lacks && missing == Missing::kMade) {
    if (auto made = DiagnosisText(record)) text = std::move(made).value();
  }
  if (live) {
    if (live->diagnosis) found = *live->diagnosis;
  } else if (!text.empty()) {
    auto stored = ParseDiagnosis(text, *bench.value());
    if (stored) found = std::move(stored).value();
  }
  return TellStory(events, found, *bench.value(), record.period_s);
}

core::Result<core::Diagnosis> Recordings::Repair(const Recording& recording, std::string* text) {
  core::Diagnosis diagnosis = core::DiagnoseRecord(recording.samples, recording.options);
  diagnosis.fit_percent.clear();  // a live run has those of the models alone
  AddModelFits(recording.samples, recording.options, diagnosis);
  *text = TextOf(diagnosis, recording);
  if (recording.record.AwaitsRecovery()) return diagnosis;  // of a part that still grows
  TRY_DONE(store_.ReplaceDiagnosis(recording.record.id, *text, WordOf(diagnosis)));
  return diagnosis;
}

core::Result<std::string> Recordings::DiagnosisText(const RunRecord& record) {
  if (record.state == RunState::kRunning) {
    if (const auto live = runs_.Find(record.id)) return live->diagnosis_json;
  }
  if (!record.diagnosis_json.empty()) return record.diagnosis_json;
  TRY(auto recording, Load(record));
  std::string text;
  TRY_DONE(Repair(recording, &text));
  return text;
}

/// Of a run that goes on: its verdict as it stands, and the estimates of the samples that are
/// stored.
core::Result<core::Diagnosis> Recordings::DiagnosisOf(const Recording& recording) {
  const RunRecord& record = recording.record;
  if (record.state == RunState::kRunning) {
    const auto live = runs_.Find(record.id);
    core::Diagnosis diagnosis;
    if (live && live->diagnosis) diagnosis = *live->diagnosis;
    core::ReplayEstimates(recording.samples, recording.options, [&](const core::Frame& frame) {
      diagnosis.estimates = frame.estimates;
    });
    return diagnosis;
  }
  if (!record.diagnosis_json.empty()) {
    auto stored = ParseDiagnosis(record.diagnosis_json, *recording.options.bench);
    if (stored) return stored;
    // Of a program too old to be read member by member: made again, and the old text stays.
    return core::DiagnoseRecord(recording.samples, recording.options);
  }
  std::string text;
  return Repair(recording, &text);
}

core::Result<Review> Recordings::ReviewOf(RunRecord record) {
  TRY(auto recording, Load(std::move(record)));
  return Reviewed(std::move(recording));
}

core::Result<Review> Recordings::ReviewOf(RunRecord record, LongTurn::Hold turn) {
  TRY(auto recording, LoadWith(std::move(record), 0, kSampleIndexMax, std::move(turn)));
  return Reviewed(std::move(recording));
}

core::Result<Review> Recordings::Reviewed(Recording recording) {
  TRY(auto diagnosis, DiagnosisOf(recording));
  TRY(auto events, Events(recording.record));
  RunStory story =
      TellStory(events, diagnosis, *recording.options.bench, recording.record.period_s);
  return Review{std::move(recording), std::move(diagnosis), std::move(events), std::move(story)};
}

core::Result<Figure> Recordings::FigureOf(const RunRecord& record,
                                          const std::string& name,
                                          const std::string& footer) {
  TRY(auto recording, Load(record));
  TRY_DONE(CheckFigure(name, recording.samples));
  TRY(auto review, Reviewed(std::move(recording)));
  return FigureOf(review, name, footer);
}

core::Result<Figure> Recordings::FigureOf(const Review& review,
                                          const std::string& name,
                                          const std::string& footer) {
  const Recording& recording = review.recording;
  const RunRecord& record = recording.record;
  FigureContext context;
  context.name = record.name.empty() ? record.id : record.name;
  context.footer = footer;
  const core::Bench& bench = *recording.options.bench;
  if (const auto planned = ControlOfPlan(record.plan_json, bench, record.period_s)) {
    ReferenceCorners corners =
        CornersOf(*planned, bench, record.period_s, SecondsOfPlan(record.plan_json));
    context.reference_t_s = std::move(corners.t_s);
    context.reference_n_rpm = std::move(corners.n_rpm);
  }
  context.faults = FaultsOfPlan(record.plan_json, bench);
  if (!HidesFaults(record.plan_json)) {
    context.faults = FaultsToShow(review.story.changes, std::move(context.faults));
  }
  context.episodes = review.story.Found();
  return MakeFigure(
      name, recording.samples, recording.options, review.diagnosis, std::move(context));
}

core::Result<core::Calibration> Recordings::CalibrationOf(const Principal& who,
                                                          const std::string& id,
                                                          const core::Bench& bench) {
  constexpr const char* kField = "calibration";
  TRY(const auto record, FinishedRecording(*this, who, id, kField));
  if (record.bench != bench.id) {
    return core::Refuse("calibration_of_other_bench", kField, {{"bench", bench.name}});
  }
  TRY(const auto text, DiagnosisText(record));
  auto calibration = ParseCalibration(text, "the calibration of " + id, bench);
  if (calibration) return calibration;
  return core::Refuse("calibration_missing", kField);
}

core::Result<Recordings::Kept> Recordings::Keep(Upload upload) {
  Recording recording;
  recording.options = std::move(upload.options);
  recording.samples = std::move(upload.samples);
  std::vector<std::int64_t> copy_of;
  if (watch_.trials_of) {
    TRY(copy_of, watch_.trials_of(recording.samples));
  }
  core::Diagnosis diagnosis;
  if (copy_of.empty()) {
    diagnosis = core::DiagnoseRecord(recording.samples, recording.options);
    if (const auto others = benches_.List()) {
      core::SuggestBench(recording.samples, recording.options, others.value(), diagnosis);
    }
  }
  RunRecord& record = recording.record;
  record.id = NewId("rec");
  record.name = upload.name;
  record.owner = upload.owner;
  record.source = "upload";
  record.server_id = member_;
  const core::Bench& bench = *recording.options.bench;
  record.bench = bench.id;
  record.period_s = recording.options.period_s;
  record.options_json = OptionsText(recording.options);
  record.created_at = clock_.Wall();
  TRY_DONE(benches_.Keep(bench, record.created_at));
  for (const std::int64_t trial : copy_of) {
    const core::Status noted = watch_.note(trial, record);
    if (!noted.ok() && noted.error().code != core::ErrorCode::kNotFound) return noted.error();
  }
  if (!copy_of.empty()) {
    record.plan_json = PlanOfCopy(copy_of, record.options_json);
    LearnNothing(recording.options);
    record.options_json = OptionsText(recording.options);
  }
  core::Status stored = store_.Begin(record);
  for (std::size_t at = 0; stored.ok() && at < recording.samples.size(); at += kSamplesPerChunk) {
    const std::size_t size = std::min(kSamplesPerChunk, recording.samples.size() - at);
    const auto chunk = std::span<const core::Sample>(recording.samples).subspan(at, size);
    stored = store_.AppendChunk(record.id, chunk.front().index, chunk);
  }
  record.verdict = WordOf(diagnosis);
  if (stored.ok()) {
    stored = store_.Finish(record.id,
                           RunState::kFinished,
                           clock_.Wall(),
                           TextOf(diagnosis, recording, upload.channels),
                           record.verdict);
  }
  if (!stored.ok()) {
    // Half an upload is of no use to anybody.
    (void)store_.Finish(record.id, RunState::kFailed, clock_.Wall(), "", "");
    (void)store_.Delete(record.id);
    return stored.error();
  }
  record.samples = static_cast<std::int64_t>(recording.samples.size());
  return Kept{std::move(record), std::move(diagnosis.verdict), std::move(copy_of)};
}

}  // namespace faultlab::server
