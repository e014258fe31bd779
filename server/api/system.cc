#include "server/api/api.h"
#include "server/api/security.h"

#include <boost/json.hpp>
#include <map>

#include "server/api/metrics_text.h"
#include "server/api/request_routing.h"
#include "server/api/rig_json.h"
#include "server/experiment/rig_access.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

core::Result<HttpResponse> Healthz(Api&, const ApiRequest&) {
  HttpResponse response;
  response.static_body = R"({"status":"ok","service":"faultlab"})";
  return response;
}

core::Result<HttpResponse> Readyz(Api& api, const ApiRequest&) {
  TRY_DONE(api.database_check());
  HttpResponse response;
  response.static_body = R"({"status":"ready"})";
  return response;
}

core::Result<HttpResponse> Metrics(Api& api, const ApiRequest&) {
  MetricsText out;
  const HttpCounters http = api.http_counters();
  out.Add("faultlab_http_connections_total", "counter", http.connections_accepted);
  out.Add("faultlab_http_connections_refused_total", "counter", http.connections_refused);
  out.Add("faultlab_http_connections_open", "gauge", http.connections_open);
  out.Add("faultlab_http_requests_total", "counter", http.requests);
  for (std::size_t i = 1; i <= 5; ++i) {
    out.Add("faultlab_http_answers_total",
            "counter",
            http.answers_by_class[i],
            Label("class", std::to_string(i) + "xx"));
  }
  out.Add("faultlab_http_deadlines_missed_total", "counter", http.deadlines_missed);
  out.Add("faultlab_http_pool_refused_total", "counter", http.pool_refused);
  out.Add("faultlab_http_pool_waiting", "gauge", http.pool_waiting);

  out.Add("faultlab_http_passed_on_total", "counter", http.passed_on);
  out.Add("faultlab_http_peers_silent_total", "counter", http.peers_silent);
  out.Add("faultlab_http_tunnels_open", "gauge", http.tunnels_open);
  out.Add("faultlab_http_waits_open", "gauge", http.waits_open);

  const StreamCounters stream = api.hub.counters();
  out.Add("faultlab_viewers_open", "gauge", stream.viewers_open);
  out.Add("faultlab_viewers_total", "counter", stream.viewers_total);
  out.Add("faultlab_stream_channels", "gauge", stream.channels_open);
  out.Add("faultlab_stream_messages_total", "counter", stream.messages_sent);
  out.Add("faultlab_stream_bytes_total", "counter", stream.bytes_sent);
  out.Add("faultlab_stream_messages_dropped_total", "counter", stream.messages_dropped);
  out.Add("faultlab_stream_inbox_refused_total", "counter", stream.inbox_refused);
  out.Add("faultlab_stream_protocol_errors_total", "counter", stream.protocol_errors);

  const RunCounters runs = api.runs.counters();
  out.Add("faultlab_runs_started_total", "counter", runs.started);
  for (std::size_t i = 1; i < 5; ++i) {
    out.Add("faultlab_runs_ended_total",
            "counter",
            runs.ended[i],
            Label("state", Name(static_cast<RunState>(i))));
  }
  out.Add("faultlab_runs_running", "gauge", api.runs.Running().size());
  out.Add("faultlab_samples_total", "counter", runs.samples);
  out.Add("faultlab_rig_overruns_total", "counter", runs.overruns);
  out.Add("faultlab_rig_gaps_total", "counter", runs.gaps);
  AddRigMetrics(out, api.rig_pool.List());
  out.Add("faultlab_isolation_tasks_total", "counter", runs.solver_tasks);
  {
    const auto state = api.service.state();
    std::map<std::string_view, std::uint64_t> rigs;
    for (const auto& [id, rig] : state->rigs) ++rigs[Name(rig.status)];
    for (const char* status :
         {"offline", "ready", "leased", "cleaning", "quarantined", "maintenance"}) {
      out.Add("faultlab_lab_rigs", "gauge", rigs[status], Label("status", status));
    }
    out.Add("faultlab_lab_tickets_waiting", "gauge", state->tickets.size());
    out.Add("faultlab_lab_bookings", "gauge", state->bookings.size());
    out.Add("faultlab_lab_sessions", "gauge", state->sessions.size());
  }
  const auto up =
      std::chrono::duration_cast<std::chrono::seconds>(api.clock.Monotonic() - api.started);
  out.Add("faultlab_uptime_seconds", "gauge", static_cast<std::uint64_t>(up.count()));

  HttpResponse response;
  response.content_type = "text/plain; version=0.0.4; charset=utf-8";
  response.body = out.Take();
  return response;
}

core::Result<HttpResponse> OpenApi(Api& api, const ApiRequest&) {
  HttpResponse response;
  static const std::string whole = WithSecurity(api.openapi);
  response.static_body = whole;
  return response;
}

core::Result<HttpResponse> ListRigs(Api& api, const ApiRequest& request) {
  std::vector<RigStatus> rigs = api.rig_pool.List();
  const bool operates = Authorize(request.who, Operation::kOperateRig, Ownership::kNone).ok();
  const RigReader reader = operates ? RigReader::kOperator : RigReader::kAnybody;
  if (operates) {
    for (RigStatus& stranger : api.rig_pool.ListUnprovenRigs()) rigs.push_back(std::move(stranger));
  }
  const auto to_json = [&](const RigStatus& rig) {
    return RigToJson(rig, api.clock.Wall(), reader);
  };
  return JsonResponse(json::object{{"items", ListOf(rigs, to_json)}});
}

core::Result<HttpResponse> ListRigCalibrations(Api& api, const ApiRequest& request) {
  TRY(const auto limit, PageLimit(request.http));
  const std::string& rig = request.http.PathParameter("id");
  if (!IsKnown(api.service, api.rig_pool, rig)) {
    return core::Refuse("no_rig", "", {{"rig", rig}});
  }
  TRY(const auto bench, BenchOfRig(api.rig_pool, api.benches, rig));
  TRY(const auto rows, api.calibrations.List(rig, bench->id, limit));
  const auto to_json = [](const RigCalibration& row) {
    return json::object{
        {"run", row.run}, {"at", Iso8601(row.at)}, {"calibration", json::parse(row.json)}};
  };
  return JsonResponse(json::object{{"items", ListOf(rows, to_json)}});
}

}  // namespace

std::span<const ApiRoute> SystemRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "/healthz", kReadPublic, kOpen, Healthz},
      {kGet, "/readyz", kReadPublic, kAnybody, Readyz},
      {kGet, "/metrics", kReadPublic, kRole, Metrics},
      {kGet, "openapi.json", kReadPublic, kOpen, OpenApi},
      {kGet, "rigs", kListRigs, kRole, ListRigs, kNoBody, kQuick, kEveryMember},
      ApiRoute{kGet, "rigs/{id}/calibrations", kListRigs, kRole, ListRigCalibrations}.Takes(
          "limit"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
