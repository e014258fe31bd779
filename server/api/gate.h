#pragma once

#include <span>
#include <string_view>

#include "core/types/result.h"
#include "server/api/request.h"
#include "server/api/request_routing.h"
#include "server/api/transfer_quota.h"
#include "server/auth/authorization.h"
#include "server/idempotency/idempotency_store.h"
#include "server/net/http_server.h"
#include "server/net/router.h"

namespace faultlab::server {

/// What body a route takes.
enum class BodyKind {
  kNone,   ///< whatever comes is not looked at
  kBytes,  ///< the handler reads it
  kJson,   ///< one JSON object (nothing is {}); other content types are refused
  kEmpty,  ///< the same without any member: an action
};
/// What a POST does that comes again with its Idempotency-Key: see Gate.
enum class Repeat {
  kAnswered,  ///< it gets the same answer
  kToldOnce,  ///< it is refused: the answer held a secret, which is not kept
  kDoneAgain  ///< the key is not looked at, and nothing of the request is kept: a password, or an
              ///< end that must not wait for the database
};
struct BodyRule {
  std::size_t bytes_max = 0;
  BodyKind kind = BodyKind::kNone;
  Repeat repeat = Repeat::kAnswered;
  bool from_anywhere = false;  ///< a page of another site may post it
};
inline constexpr BodyRule kNoBody{};
inline constexpr BodyRule kJson{1 << 20, BodyKind::kJson};
inline constexpr BodyRule kJsonForSecret{1 << 20, BodyKind::kJson, Repeat::kToldOnce};
inline constexpr BodyRule kJobBatch{4 << 20, BodyKind::kJson};  ///< of 10,000 runs
inline constexpr BodyRule kEmpty{1 << 20, BodyKind::kEmpty};
inline constexpr BodyRule kEmptyForSecret{1 << 20, BodyKind::kEmpty, Repeat::kToldOnce};
inline constexpr BodyRule kSignInJson{4 << 10, BodyKind::kJson};  ///< of people not known yet
inline constexpr BodyRule kPasswords{4 << 10, BodyKind::kJson, Repeat::kDoneAgain};
inline constexpr BodyRule kEmptyToEnd{1 << 20, BodyKind::kEmpty, Repeat::kDoneAgain};
/// That a page of another site makes a browser post: it proves by itself who sends it.
inline constexpr BodyRule kForeignForm{64 << 10, BodyKind::kBytes, Repeat::kDoneAgain, true};
inline constexpr BodyRule kClassList{1 << 20, BodyKind::kBytes};
inline constexpr BodyRule kUpload{20 << 20, BodyKind::kBytes};

/// What a request costs. kHeavy computes for more than some milliseconds; kTransfer as well, and
/// its body or answer grows with the run: a caller has two such at work or unsent at most, a few
/// more wait for one of them. kPassword hashes one, kOutside asks something elsewhere that the {id}
/// of its path names: a sign-in provider, the camera of a run, the learning platforms of a course.
enum class Cost { kQuick, kHeavy, kTransfer, kPassword, kOutside };

/// Who may call: everybody; whoever the matrix allows; whoever it allows on the run of the path's
/// {id}, which the handler then has in its request; or the handler asks about the object itself.
/// kAnybody is kOpen for handlers that touch the disk: nobody is asked, but on the pool.
enum class Guard { kOpen, kAnybody, kRole, kRun, kObject };

struct Api;
using ApiHandler = core::Result<HttpResponse> (*)(Api&, const ApiRequest&);

struct ApiRoute {
  HttpMethod method;
  std::string_view pattern;  ///< "runs/{id}" below /api/v1/, or "/healthz"
  Operation operation;
  Guard guard;
  ApiHandler handler;
  BodyRule body = kNoBody;
  Cost cost = Cost::kQuick;
  LivesAt lives_at = LivesAt::kAnywhere;
  std::string_view query{};
  bool by_people = false;  ///< API keys are refused, whatever their scopes

  /// What no program may do, though the matrix would let it: links by which people sign in.
  constexpr ApiRoute ByPeople() const {
    ApiRoute out = *this;
    out.by_people = true;
    return out;
  }
  /// The parameters of its query, "cursor limit"; others are refused by name. "*": whatever another
  /// site sends.
  constexpr ApiRoute Takes(std::string_view names) const {
    ApiRoute out = *this;
    out.query = names;
    return out;
  }
};

/// The words of a table of routes.
namespace routing {
using enum HttpMethod;
using enum Operation;
using enum Guard;
using enum Cost;
using enum LivesAt;
}  // namespace routing

/// What stands in front of every handler: who calls, whether they may, and what they sent.
///
/// A POST of a signed-in caller with an Idempotency-Key is done once: the same request with that
/// key gets the same answer for a day (a secret is not told again: "answer_told_once"), another one
/// is refused. What was refused has done nothing, and is tried again.
///
/// A route that takes `wait` answers when what is told of has ended, or has changed since the
/// If-None-Match of the caller, or after so many seconds (60 at most): the request is done again
/// from time to time, with all that stands in front of it.
///
/// A GET of JSON without a version of its own has a weak ETag of its content, 304 for whoever has
/// it; but for answers that are longer than Spool::kMemoryMax or joined of several servers.
///
///   Router --HttpRequest--> Gate: caller, matrix, run, body, key --ApiRequest--> handler
///                            +-- what lives at another server --> that server
class Gate {
 public:
  struct Parts {
    IdempotencyStore& answers;
    RequestRouting& routing;
    Api& api;
  };
  /// All parts, and the gate, must outlive the router.
  explicit Gate(Parts parts) : parts_(parts) {}

  /// Puts a table into the router. Refusals become problem+json. kOpen routes run on the network
  /// thread, the others on the pool of their cost. Who may not call is refused before the body is
  /// read.
  void AddRoutes(Router& router, std::span<const ApiRoute> routes);

  /// Decides about GET /ws?code=..
  UpgradeDecision DecideUpgrade(const HttpRequest& request);

 private:
  core::Result<Principal> CallerOf(const ApiRoute& route, const HttpRequest& http);
  Admission Admit(const ApiRoute& route, const HttpRequest& http);
  bool StillMay(const ApiRoute& route, const HttpRequest& http);
  RouteAnswer Serve(const ApiRoute& route, const HttpRequest& http);
  core::Result<RouteAnswer> Answer(const ApiRoute& route,
                                   const HttpRequest& http,
                                   const Principal& who);
  core::Result<HttpResponse> Remembered(const ApiRoute& route, const ApiRequest& request);

  Parts parts_;
  TransferQuota transfers_{2, 4};
};

}  // namespace faultlab::server
