#pragma once

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/api/diagnosis_cache.h"
#include "server/api/iso8601.h"
#include "server/api/transfer_slots.h"
#include "server/auth/authenticator.h"
#include "server/auth/authorization.h"
#include "server/auth/principal.h"
#include "server/clock.h"
#include "server/net/http_server.h"
#include "server/net/router.h"
#include "server/run/rig_bay.h"
#include "server/run/run_manager.h"
#include "server/storage/recording_store.h"
#include "server/storage/rig_calibrations.h"
#include "server/stream/stream_hub.h"
#include "server/stream/stream_tokens.h"

namespace faultlab::server {

struct LabApi;

/// What the endpoints work on. Outlives the HTTP server.
struct ApiContext {
  RunManager& runs;
  RigBay& bay;
  RecordingStore& store;
  RigCalibrations& calibrations;
  StreamHub& hub;
  StreamTokens& tokens;
  Authenticator& authenticator;
  const Clock& clock;
  double speed = 1.0;  ///< of simulated and replayed rigs
  std::uint64_t default_seed = 1;
  std::string_view openapi{};  ///< server/api/openapi.json, embedded
  std::function<HttpCounters()> http_counters{};
  std::function<core::Status()> database_check{};  ///< cheap: for /readyz
  MonotonicTime started{};
  DiagnosisCache diagnoses{};
  TransferSlots transfers{2, 4};
  LabApi* lab = nullptr;  ///< accounts, queue, calendar, jobs; null: guests only
  /// A rig in the hands of the caller's lease, for a run of at most `length`: of the session that
  /// they have on it, or of practice on a simulator ("": any free one).
  std::function<core::Result<RigHold>(
      const Principal&, const std::string& rig, std::chrono::milliseconds length)>
      hold_rig{};
  /// May this person command what runs on this rig now?
  std::function<bool(const Principal&, const std::string& rig)> may_command{};
};

struct ApiRequest {
  const HttpRequest& http;
  const Principal& who;
};

/// What body a route takes.
struct BodyRule {
  std::size_t bytes_max = 0;
  bool is_json = false;  ///< other content types are refused
};
inline constexpr BodyRule kNoBody{};
inline constexpr BodyRule kJson{1 << 20, true};
inline constexpr BodyRule kSignInJson{4 << 10, true};  ///< from people who are not known yet
inline constexpr BodyRule kClassList{1 << 20};
inline constexpr BodyRule kUpload{20 << 20};

/// kLarge: the answer grows with the run. A caller has two such answers at work or unsent at most;
/// a few more wait for one of them.
enum class AnswerSize { kSmall, kLarge };

/// Where the object of a request lives, when several servers share the database. Evaluated after
/// the caller is known and before the handler: see whereabouts.h.
enum class LivesAt {
  kAnywhere,     ///< in the database: any server answers
  kRunsMember,   ///< while the run of {id} lives: at the server that records it
  kRunsViewers,  ///< as kRunsMember, and while its viewers are still told of its end
  kRigsMember,   ///< at the server that has the rig of {id}
  kBodysRig,     ///< at the server that has the rig which the body names
  kEveryMember,  ///< a list: each server has its part
};

using ApiHandler = core::Result<HttpResponse> (*)(ApiContext&, const ApiRequest&);

/// Who may call: everybody; whoever the matrix allows; or the handler asks about the object itself.
/// kAnybody is kOpen for handlers that touch the disk: nobody is asked, but on the pool.
enum class Guard { kOpen, kRole, kObject, kAnybody };

struct ApiRoute {
  HttpMethod method;
  std::string_view pattern;
  Operation operation;
  Guard guard;
  ApiHandler handler;
  BodyRule body = kNoBody;
  AnswerSize answer = AnswerSize::kSmall;
  LivesAt lives_at = LivesAt::kAnywhere;
};

/// The table of issue-2 endpoints: routes.cc. Later groups have a table of their own each.
std::vector<ApiRoute> ExperimentRoutes();

/// Puts a table into the router: authenticates, asks the matrix, turns refusals into problem+json.
/// kOpen routes run on the network thread, the others on the pool. Who may not call is refused
/// before the body is read.
void AddRoutes(Router& router, ApiContext& api, const std::vector<ApiRoute>& routes);

/// Decides about GET /ws?code=..
UpgradeDecision DecideUpgrade(ApiContext& api, const HttpRequest& request);

// For handlers.

HttpResponse JsonResponse(const boost::json::value& value, int status = 200);
HttpResponse ProblemOf(const core::Error& error);
int HttpStatus(core::ErrorCode code);
/// A file to save: Content-Disposition with a safe name.
HttpResponse Download(std::string bytes, std::string_view content_type, std::string file_name);
/// ?limit=, 1..200, default 50.
core::Result<int> PageLimit(const HttpRequest& request);
/// A whole-number query parameter.
core::Result<std::int64_t> QueryInteger(const HttpRequest& request,
                                        std::string_view name,
                                        std::int64_t fallback,
                                        std::int64_t lo,
                                        std::int64_t hi);
/// Refuses query parameters that are not in `known`, by name, and any that is not UTF-8.
core::Status OnlyQuery(const HttpRequest& request, std::initializer_list<std::string_view> known);

Ownership OwnershipOf(const Principal& who, std::string_view owner_key);
/// The run of the path's {id}, if `who` may do `operation` on it.
core::Result<RunRecord> AuthorizedRun(ApiContext& api,
                                      const ApiRequest& request,
                                      Operation operation);

}  // namespace faultlab::server
