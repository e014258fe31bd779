#include <array>
#include <boost/json.hpp>

#include "core/types/verdict.h"
#include "server/api/run/handlers.h"
#include "server/experiment/plan_json.h"
#include "server/json/json_reader.h"
#include "server/json/kept_json.h"
#include "server/story/run_story.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::size_t kNoteBytesMax = 2000;
constexpr int kEventsInList = 500;  ///< of each run

json::object RecordToJson(const RunRecord& record) {
  return {{"id", record.id},
          {"name", record.name},
          {"note", record.note},
          {"rig", record.rig},
          {"bench", record.bench},
          {"source", record.source},
          {"owner", record.owner},
          {"state", Name(record.state)},
          {"epoch", record.epoch},
          {"period_s", record.period_s},
          {"created_at", Iso8601(record.created_at)},
          {"ended_at", TimeOrNull(record.ended_at)},
          {"samples", record.samples},
          {"verdict", TextOrNull(record.verdict)},
          {"plan", ParsedOr(record.plan_json, json::object{})}};
}

/// A live run knows more than the database does.
void AddLive(json::object& out, const RunSnapshot& live) {
  out["state"] = Name(live.state);
  out["samples"] = live.samples;
  out["verdict"] = live.verdict;
}

/// The run has let go of its rig, and its end is on the way into the database.
bool WaitsForItsEnd(const Api& api, const std::string& id) {
  const auto live = api.runs.Find(id);
  return live && live->state == RunState::kRunning && !live->on_rig;
}

RunRecord RecordOf(const RunSnapshot& live) {
  RunRecord record;
  record.id = live.id;
  record.name = live.name;
  record.rig = live.rig;
  record.bench = live.bench;
  record.source = "run";
  record.owner = live.owner;
  record.epoch = static_cast<std::uint64_t>(live.epoch);
  record.period_s = live.period_s;
  record.created_at = live.created_at;
  record.plan_json = live.plan_json;
  return record;
}

json::array EventsOf(std::span<const RecordedEvent> events) {
  return ListOf(events, [](const RecordedEvent& event) { return ParsedOr(event.json); });
}

HttpResponse Created(Api& api, const RunSnapshot& started) {
  const RunRecord record = RecordOf(started);
  json::object out = RecordToJson(record);
  AddLive(out, started);
  out["camera"] = HasCamera(api, record);
  HttpResponse response = JsonResponse(out, 201);
  response.headers.emplace_back("Location", "/api/v1/runs/" + started.id);
  return response;
}

constexpr std::array kVerdicts{Name(core::VerdictKind::kCalibrating),
                               Name(core::VerdictKind::kNominal),
                               Name(core::VerdictKind::kFault),
                               Name(core::VerdictKind::kUnknownFault),
                               Name(core::VerdictKind::kNotExcited)};

/// One's own runs; everybody's for whoever may read them; with ?course= those of its students.
core::Result<RunFilter> FilterOf(Api& api, const ApiRequest& request) {
  RunFilter filter;
  TRY(const auto source, QueryWord(request.http, "source", {"run", "upload"}));
  filter.source = source.value_or("run");
  TRY(filter.text, QuerySearch(request.http, "q"));
  filter.rig = request.http.Query("rig");
  TRY(filter.verdict, QueryWord(request.http, "verdict", kVerdicts));
  TRY(const auto starred, QueryWord(request.http, "starred", {"true"}));
  if (starred) filter.starred_by = request.who.owner_key();
  const bool all = Authorize(request.who, Operation::kReadRun, Ownership::kForeign).ok();
  if (!request.http.Query("course")) {
    if (!all) filter.owner = request.who.owner_key();
    return filter;
  }
  TRY(auto course, QueryInteger(request.http, "course", 0, 1, INT64_MAX));
  TRY(auto teaches, api.accounts.Teaches(request.who.user_id, course));
  const bool may =
      all || (teaches && Authorize(request.who, Operation::kReadRun, Ownership::kCourse).ok());
  if (!may) return core::Refuse("no_course", "course");
  filter.course = course;
  return filter;
}

void NoteOnRun(Api& api, const ApiRequest& request, const char* verb) {
  NoteOnRun(api, {request.who, verb, "run:" + request.run.id, "of " + request.run.owner});
}

core::Result<HttpResponse> CreateRun(Api& api, const ApiRequest& request) {
  TRY(auto plan, api.experiments.Read(request.body));
  TRY(const auto started, api.experiments.Start(request.who, StartedBy::kPerson, std::move(plan)));
  return Created(api, started);
}

core::Result<HttpResponse> ListRuns(Api& api, const ApiRequest& request) {
  TRY(auto limit, PageLimit(request.http));
  TRY(auto filter, FilterOf(api, request));
  TRY(auto page, api.store.List(request.http.Query("cursor").value_or(""), limit, filter));
  OpenDue(api, page.items);
  std::vector<std::string> ids;
  for (const RunRecord& record : page.items) ids.push_back(record.id);
  TRY(auto events, api.store.EventsOf(ids, kStoryEventKinds, kEventsInList));
  TRY(const auto starred, api.store.StarredOf(request.who.owner_key(), ids));
  json::array items;
  for (const RunRecord& record : page.items) {
    json::object item = RecordToJson(record);
    std::vector<RecordedEvent>& told = events.at(record.id);
    if (record.state == RunState::kRunning) {
      if (auto live = api.runs.Find(record.id)) {
        AddLive(item, *live);
        told = std::move(live->events);
      }
    }
    item["story"] = ToJson(api.recordings.StoryOf(record, std::move(told), Missing::kLeftOut),
                           kStoryInListMost);
    item["starred"] = starred.contains(record.id);
    items.push_back(std::move(item));
  }
  return ListAnswer(std::move(items), page.next_cursor);
}

core::Result<HttpResponse> GetRun(Api& api, const ApiRequest& request) {
  json::object out = RecordToJson(request.run);
  if (request.run.state == RunState::kRunning) {
    if (const auto live = api.runs.Find(request.run.id)) AddLive(out, *live);
  }
  TRY(auto events, api.recordings.Events(request.run));
  TRY(const auto starred,
      api.store.StarredOf(request.who.owner_key(), std::span(&request.run.id, 1)));
  out["starred"] = starred.contains(request.run.id);
  out["loop"] = ParsedOr(LoopText(events));
  out["events"] = EventsOf(events);
  out["story"] = ToJson(api.recordings.StoryOf(request.run, events, Missing::kMade));
  out["camera"] = HasCamera(api, request.run);
  return JsonUntilSettled(out, request.run.state != RunState::kRunning);
}

core::Result<HttpResponse> ListEvents(Api& api, const ApiRequest& request) {
  TRY(const auto events, api.recordings.Events(request.run));
  return JsonResponse(json::object{{"items", EventsOf(events)}});
}

/// Name and note are its owner's, a star is anybody's own.
core::Result<HttpResponse> DescribeRun(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  std::optional<std::string> name, note;
  if (in.Has("name")) name = in.Text("name", kNameBytesMax);
  if (in.Has("note")) note = in.Text("note", kNoteBytesMax);
  const bool has_star = in.Has("starred");
  const bool star = in.BooleanOr("starred", false);
  if (auto error = in.Finish()) return *error;
  if (name || note) {
    TRY(const auto whose,
        api.accounts.RelationTo(request.who, request.run.owner, request.run.created_at));
    const core::Status allowed = Authorize(request.who, Operation::kDeleteRun, whose);
    if (!allowed.ok() && allowed.error().reason == "role_may_not") {
      return core::Refuse("only_owner_names");
    }
    if (!allowed.ok()) return allowed.error();
    TRY_DONE(api.store.Describe(request.run.id, name, note));
  }
  const std::string who = request.who.owner_key();
  if (has_star) {
    // What is stored is the caller's own, and a key that only reads stores nothing.
    TRY_DONE(Authorize(request.who, Operation::kStartRun, Ownership::kOwn));
    TRY_DONE(api.store.SetStar(request.run.id, who, star));
  }
  TRY(const auto record, api.store.Get(request.run.id));
  TRY(const auto starred, api.store.StarredOf(who, std::span(&request.run.id, 1)));
  return JsonResponse(json::object{{"id", record.id},
                                   {"name", record.name},
                                   {"note", record.note},
                                   {"starred", starred.contains(record.id)}});
}

core::Result<HttpResponse> StopRun(Api& api, const ApiRequest& request) {
  if (request.run.state != RunState::kRunning || WaitsForItsEnd(api, request.run.id)) {
    return core::Refuse("run_ended");
  }
  const bool own = OwnershipOf(request.who, request.run.owner) == Ownership::kOwn;
  const core::Status stopped =
      api.runs.Stop(request.run.id, own ? kStoppedByOwner : kStoppedByAnother);
  if (!stopped.ok() && stopped.error().code == core::ErrorCode::kNotFound) {
    return core::Refuse("run_ended");
  }
  if (!stopped.ok()) return stopped.error();
  NoteOnRun(api, request, "stop_run");
  return JsonResponse(json::object{{"id", request.run.id}, {"state", "stopping"}}, 202);
}

core::Result<HttpResponse> LearnAgain(Api& api, const ApiRequest& request) {
  if (request.run.state != RunState::kRunning) return core::Refuse("run_ended");
  TRY(const auto begun, api.runs.LearnAgain(request.run.id));
  const double until_s = begun.waits_until_s.value_or(0.0);
  return JsonResponse(json::object{{"id", request.run.id}, {"learning_until_s", until_s}}, 202);
}

core::Result<HttpResponse> DeleteRun(Api& api, const ApiRequest& request) {
  // Of a copy of somebody's sealed record, its trial keeps who brought it.
  const bool copy = !CopiedTrials(request.run.plan_json).empty();
  if (IsSealed(request.run.plan_json) && !copy) return core::Refuse("run_sealed");
  const core::Status deleted = api.store.Delete(request.run.id);
  if (!deleted.ok() && deleted.error().reason == "run_not_ended" &&
      WaitsForItsEnd(api, request.run.id)) {
    return core::Refuse("end_not_stored");
  }
  if (!deleted.ok()) return deleted.error();
  NoteOnRun(api, request, "delete_run");
  return NoContent();
}

core::Result<HttpResponse> IssueStreamToken(Api& api, const ApiRequest& request) {
  // Rule 9: others watch, whatever their role. On a rig of the lab the session must be one's own.
  const Ownership whose = OwnershipOf(request.who, request.run.owner);
  const bool can_command = whose == Ownership::kOwn &&
                           api.rigs.MayCommand(request.who, request.run.rig) &&
                           Authorize(request.who, Operation::kChangeRun, whose).ok();
  ViewerOwner owner = ViewerOwnerOf(request.who);
  if (whose != Ownership::kOwn) {
    owner.run_owner = request.run.owner;
    owner.run_made_ms = ToMilliseconds(request.run.created_at);
  }
  const std::string code = api.tokens.Issue({request.run.id, std::move(owner), can_command});
  return JsonResponse(json::object{{"code", code}, {"expires_in_s", kStreamTokenLife.count()}},
                      201);
}

}  // namespace

void OpenDue(Api& api, std::vector<RunRecord>& records) {
  // To open a run takes a diagnosis: what is left of the list is opened by the next looks at it.
  constexpr int kOpenedAtOnce = 4;
  int opened = 0;
  for (RunRecord& record : records) {
    if (!IsSealed(record.plan_json) || opened == kOpenedAtOnce) continue;
    auto now = api.recordings.Opened(record);
    if (!now) continue;  // it has just been deleted
    if (!IsSealed(now.value().plan_json)) ++opened;
    record = std::move(now).value();
  }
}

void NoteOnRun(Api& api, const AuditNote& note) {
  if (note.who.signed_in()) api.audit.Add(note.who, note.verb, note.object, note.detail);
  if (!note.who.signed_in()) api.audit.AddBounded(note);
}

std::span<const ApiRoute> RunsRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kPost, "runs", kStartRun, kRole, CreateRun, kJson, kQuick, kBodysRig},
      ApiRoute{kGet, "runs", kReadRun, kObject, ListRuns}.Takes(
          "cursor limit course q rig source verdict starred"),
      ApiRoute{kGet, "runs/{id}", kReadRun, kRun, GetRun, kNoBody, kQuick, kRunsMember}.Takes(
          "wait"),
      {kPatch, "runs/{id}", kReadRun, kRun, DescribeRun, kJson},
      {kDelete, "runs/{id}", kDeleteRun, kRun, DeleteRun},
      {kPost, "runs/{id}/stop", kChangeRun, kRun, StopRun, kEmptyToEnd, kQuick, kRunsMember},
      {kPost, "runs/{id}/calibration", kChangeRun, kRun, LearnAgain, kEmpty, kQuick, kRunsMember},
      {kPost,
       "runs/{id}/stream-token",
       kReadRun,
       kRun,
       IssueStreamToken,
       kEmptyForSecret,
       kQuick,
       kRunsViewers},
      {kGet, "runs/{id}/events", kReadRun, kRun, ListEvents, kNoBody, kQuick, kRunsMember},
  });
  return kRoutes;
}

}  // namespace faultlab::server
