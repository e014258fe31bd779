#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "server/net/http.h"
#include "server/net/peer_address.h"

namespace faultlab::server {

/// Where a handler runs. Nothing that touches disk, database or a picture may be kInline. What
/// computes for more than some milliseconds is kHeavy, what hashes a password kPassword, what asks
/// a site elsewhere kOutside: the rest of the page never waits for any of them.
enum class RunsOn { kInline, kPool, kHeavy, kPassword, kOutside };

/// The answer to a header: may its body be read, its handler be run?
struct Admission {
  std::optional<HttpResponse> refusal{};
  bool not_yet = false;          ///< ask again in a moment; for good, it is the refusal
  std::shared_ptr<void> held{};  ///< let go when the request has been answered or is asked again
  std::string caller{};          ///< with whom others take turns; empty: the client's address
  bool known = false;            ///< the caller has an account: strangers give way to it
};

struct Route {
  HttpMethod method = HttpMethod::kGet;
  std::string pattern;  ///< "/api/v1/runs/{id}/plots/{figure}.png"; "/*" at the end takes any rest
  RunsOn runs_on = RunsOn::kPool;
  std::size_t body_bytes_max = 0;
  std::function<RouteAnswer(const HttpRequest&)> handle;
  /// Asked, on the pool, before a body is stored that did not come along with its header; request
  /// without the body. May be empty.
  std::function<Admission(const HttpRequest&)> admit{};
  bool always_admit = false;  ///< `admit` is asked about every request
  /// Asked, on the pool, from time to time while an answer is on its way: when it says no, the
  /// connection is cut. May be empty.
  std::function<bool(const HttpRequest&)> still_may{};
  /// The {name} whose value is the request's lane in its pool; see PoolLimits. Empty: none.
  std::string lane{};
};

/// Finds the route of a request. Literal segments win over {names}, both over "/*".
/// Immutable while the server runs, so any thread may ask.
class Router {
 public:
  void Add(Route route);

  struct Match {
    const Route* route = nullptr;  ///< nullptr: no such path (404) or method (405)
    std::string allow;             ///< for 405: "GET, HEAD"; empty for 404
  };
  /// Fills request.path_parameters. HEAD is answered by the GET route.
  Match Find(HttpRequest& request) const;

  const std::vector<Route>& routes() const { return routes_; }

 private:
  std::vector<Route> routes_;
  std::unordered_map<std::string, std::size_t> literal_gets_;  ///< patterns without {names}
};

}  // namespace faultlab::server
