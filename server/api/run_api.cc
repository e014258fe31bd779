#include <boost/json.hpp>

#include "core/diagnosis/pipeline.h"
#include "hardware/replay_rig.h"
#include "server/api/handlers.h"
#include "server/api/json_reader.h"
#include "server/api/lab/handlers.h"
#include "server/api/run_body.h"
#include "server/run/run_messages.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

json::value ParsedOr(std::string_view text, json::value fallback) {
  boost::system::error_code ec;
  json::value value = json::parse(text, ec);
  return ec ? fallback : value;
}

json::object RecordToJson(const RunRecord& record) {
  json::object out{{"id", record.id},
                   {"name", record.name},
                   {"rig", record.rig},
                   {"source", record.source},
                   {"owner", record.owner},
                   {"state", Name(record.state)},
                   {"epoch", record.epoch},
                   {"period_s", record.period_s},
                   {"created_at", Iso8601(record.created_at)},
                   {"ended_at", nullptr},
                   {"samples", record.samples},
                   {"verdict", nullptr},
                   {"plan", ParsedOr(record.plan_json, json::object{})}};
  if (record.ended_at) out["ended_at"] = Iso8601(*record.ended_at);
  if (!record.verdict.empty()) out["verdict"] = record.verdict;
  return out;
}

/// A live run knows more than the database does.
void AddLive(json::object& out, const RunSnapshot& live) {
  out["state"] = Name(live.state);
  out["samples"] = live.samples;
  out["verdict"] = live.verdict;
}

RunRecord RecordOf(const RunSnapshot& live) {
  RunRecord record;
  record.id = live.id;
  record.name = live.name;
  record.rig = live.rig;
  record.source = "run";
  record.owner = live.owner;
  record.epoch = static_cast<std::uint64_t>(live.epoch);
  record.period_s = live.period_s;
  record.created_at = live.created_at;
  record.plan_json = live.plan_json;
  return record;
}

/// The rig's last event carries what its loop was like.
json::value LoopOf(const json::array& events) {
  for (const json::value& event : events) {
    const json::object* object = event.if_object();
    const json::value* loop = object != nullptr ? object->if_contains("loop") : nullptr;
    if (loop != nullptr) return *loop;
  }
  return nullptr;
}

HttpResponse Created(const RunSnapshot& started) {
  json::object out = RecordToJson(RecordOf(started));
  AddLive(out, started);
  HttpResponse response = JsonResponse(out, 201);
  response.headers.emplace_back("Location", "/api/v1/runs/" + started.id);
  return response;
}

core::Result<RunRequest> ReplayOf(ApiContext& api, const ApiRequest& request, const RunBody& body) {
  const auto refuse = [](core::Error error) {
    error.field = "/recording";
    return error;
  };
  auto source = api.store.Get(body.recording);
  if (!source) return refuse(source.error());
  const auto whose = RelationTo(api, request.who, source.value().owner);
  if (!whose) return refuse(whose.error());
  const core::Status allowed = Authorize(request.who, Operation::kReadRun, whose.value());
  if (!allowed.ok()) return refuse(allowed.error());
  auto samples = api.store.LoadSamples(body.recording, 0, source.value().samples + 1'000'000'000);
  if (!samples) return refuse(samples.error());
  if (samples.value().empty()) {
    return core::Error{core::ErrorCode::kInvalid, "The recording is empty.", "/recording"};
  }
  auto events = api.store.LoadEvents(body.recording);
  if (!events) return refuse(events.error());

  hardware::ReplayRigOptions options;
  options.speed = api.speed;
  for (const RecordedEvent& recorded : events.value()) {
    auto event = ToRigEvent(recorded);
    const bool of_the_plant = event && (event->kind == hardware::RigEventKind::kFaultCommanded ||
                                        event->kind == hardware::RigEventKind::kRelayConfirmed ||
                                        event->kind == hardware::RigEventKind::kGap);
    if (of_the_plant) options.events.push_back(std::move(*event));
  }
  RunRequest run;
  run.name = body.name.empty() ? "replay of " + source.value().name : body.name;
  run.plan = hardware::ReplayPlan(source.value().period_s);
  std::shared_ptr<hardware::Rig> rig =
      hardware::MakeReplayRig(std::move(samples).value(), std::move(options));
  json::object plan = PlanToJson(body, rig->description());
  plan["period_s"] = source.value().period_s;
  run.plan_json = json::serialize(plan);
  run.hold = RigHold(std::move(rig));
  return run;
}

core::Result<RunRequest> ExperimentOf(ApiContext& api,
                                      const ApiRequest& request,
                                      const RunBody& body) {
  const auto length =
      std::chrono::ceil<std::chrono::milliseconds>(std::chrono::duration<double>(body.duration_s));
  // The rig comes first, for any one may do: the plan is resolved for the one that runs it.
  auto hold = api.hold_rig(request.who, body.rig, length);
  if (!hold) return hold.error();
  const hardware::RigDescription& about = hold.value().rig().description();
  auto plan = ResolvePlan(body, about);
  if (!plan) return plan.error();
  RunRequest run;
  run.name = body.name;
  run.plan = std::move(plan).value();
  run.plan_json = json::serialize(PlanToJson(body, about));
  run.pipeline.values = about.any_value ? core::ValuePrior::kNone : core::ValuePrior::kTable2;
  run.hold = std::move(hold).value();
  return run;
}

/// One's own runs; everybody's for whoever may read them; with ?course= those of its students.
core::Result<RunFilter> FilterOf(ApiContext& api, const ApiRequest& request) {
  RunFilter filter;
  filter.source = "run";
  const bool all = Authorize(request.who, Operation::kReadRun, Ownership::kForeign).ok();
  if (!request.http.Query("course")) {
    if (!all) filter.owner = request.who.owner_key();
    return filter;
  }
  auto course = QueryInteger(request.http, "course", 0, 1, INT64_MAX);
  if (!course) return course.error();
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  auto teaches = lab.value()->accounts.Teaches(request.who.user_id, course.value());
  if (!teaches) return teaches.error();
  const bool may = all || (teaches.value() &&
                           Authorize(request.who, Operation::kReadRun, Ownership::kCourse).ok());
  if (!may) return core::Error{core::ErrorCode::kInvalid, "You teach no such course.", "course"};
  filter.course = course.value();
  return filter;
}

}  // namespace

core::Result<HttpResponse> CreateRun(ApiContext& api, const ApiRequest& request) {
  auto text = ExpandFaultSet(api, request.who, request.http.body);
  if (!text) return text.error();
  auto body = ParseRunBody(text.value(), api.default_seed);
  if (!body) return body.error();
  auto run = body.value().recording.empty() ? ExperimentOf(api, request, body.value())
                                            : ReplayOf(api, request, body.value());
  if (!run) return run.error();
  RunRequest ready = std::move(run).value();
  ready.owner = request.who.owner_key();
  auto started = api.runs.Start(std::move(ready));
  if (!started) return started.error();
  return Created(started.value());
}

core::Result<HttpResponse> ListRuns(ApiContext& api, const ApiRequest& request) {
  const core::Status query = OnlyQuery(request.http, {"cursor", "limit", "course"});
  if (!query.ok()) return query.error();
  auto limit = PageLimit(request.http);
  if (!limit) return limit.error();
  auto filter = FilterOf(api, request);
  if (!filter) return filter.error();
  auto page =
      api.store.List(request.http.Query("cursor").value_or(""), limit.value(), filter.value());
  if (!page) return page.error();
  json::array items;
  for (const RunRecord& record : page.value().items) {
    json::object item = RecordToJson(record);
    if (record.state == RunState::kRunning) {
      if (const auto live = api.runs.Find(record.id)) AddLive(item, *live);
    }
    items.push_back(std::move(item));
  }
  json::object out{{"items", std::move(items)}, {"next_cursor", nullptr}};
  if (!page.value().next_cursor.empty()) out["next_cursor"] = page.value().next_cursor;
  return JsonResponse(out);
}

core::Result<HttpResponse> GetRun(ApiContext& api, const ApiRequest& request) {
  auto record = AuthorizedRun(api, request, Operation::kReadRun);
  if (!record) return record.error();
  json::object out = RecordToJson(record.value());
  json::array events;
  const auto live =
      record.value().state == RunState::kRunning ? api.runs.Find(record.value().id) : std::nullopt;
  if (live) {
    AddLive(out, *live);
    for (const RecordedEvent& event : live->events) events.push_back(ParsedOr(event.json, nullptr));
  } else {
    auto stored = api.store.LoadEvents(record.value().id);
    if (!stored) return stored.error();
    for (const RecordedEvent& event : stored.value()) {
      events.push_back(ParsedOr(event.json, nullptr));
    }
  }
  out["loop"] = LoopOf(events);
  out["events"] = std::move(events);
  return JsonResponse(out);
}

core::Result<HttpResponse> ListEvents(ApiContext& api, const ApiRequest& request) {
  auto whole = GetRun(api, request);
  if (!whole) return whole.error();
  json::value run = json::parse(whole.value().body);
  return JsonResponse(json::object{{"items", std::move(run.as_object()["events"])}});
}

core::Result<HttpResponse> StopRun(ApiContext& api, const ApiRequest& request) {
  auto record = AuthorizedRun(api, request, Operation::kChangeRun);
  if (!record) return record.error();
  auto body = ParseJsonObject(request.http.body);
  if (!body) return body.error();
  ObjectReader in(body.value(), "");
  if (auto error = in.Finish()) return *error;
  if (record.value().state != RunState::kRunning) {
    return core::Error{core::ErrorCode::kConflict, "The run has ended already.", {}};
  }
  const core::Status stopped = api.runs.Stop(record.value().id, "stopped by a person");
  if (!stopped.ok() && stopped.error().code == core::ErrorCode::kNotFound) {
    return core::Error{core::ErrorCode::kConflict, "The run has ended already.", {}};
  }
  if (!stopped.ok()) return stopped.error();
  return JsonResponse(json::object{{"id", record.value().id}, {"state", "stopping"}}, 202);
}

core::Result<HttpResponse> DeleteRun(ApiContext& api, const ApiRequest& request) {
  auto record = AuthorizedRun(api, request, Operation::kDeleteRun);
  if (!record) return record.error();
  const core::Status deleted = api.store.Delete(record.value().id);
  if (!deleted.ok()) return deleted.error();
  HttpResponse response;
  response.status = 204;
  return response;
}

core::Result<HttpResponse> IssueStreamToken(ApiContext& api, const ApiRequest& request) {
  auto record = AuthorizedRun(api, request, Operation::kReadRun);
  if (!record) return record.error();
  // Rule 9: others watch, whatever their role. On a rig of the lab the session must be one's own.
  const Ownership whose = OwnershipOf(request.who, record.value().owner);
  const bool can_command = whose == Ownership::kOwn &&
                           api.may_command(request.who, record.value().rig) &&
                           Authorize(request.who, Operation::kChangeRun, whose).ok();
  const std::string code =
      api.tokens.Issue({record.value().id, request.who.owner_key(), can_command});
  return JsonResponse(json::object{{"code", code}, {"expires_in_s", kStreamTokenLife.count()}},
                      201);
}

}  // namespace faultlab::server
