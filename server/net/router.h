#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "server/net/http.h"
#include "server/net/peer_address.h"

namespace faultlab::server {

/// Where a handler runs. A handler that uses disk, database or a picture must not be kInline. More
/// than some milliseconds of computing is kHeavy, password hashing kPassword, a request to an
/// external site kOutside: the rest of the page never waits for these.
enum class RunsOn { kInline, kPool, kHeavy, kPassword, kOutside };

/// The answer to a header: whether its body may be read and its handler be run.
struct Admission {
  std::optional<HttpResponse> refusal{};
  bool not_yet = false;          ///< ask again in a moment; when tries run out, it is the refusal
  std::shared_ptr<void> held{};  ///< released after the answer, or before asking again
  std::string caller{};          ///< takes turns with other callers; empty: the client's address
  bool known = false;            ///< the caller has an account (precedence)
};

struct Route {
  HttpMethod method = HttpMethod::kGet;
  std::string pattern;  ///< "/api/v1/runs/{id}/plots/{figure}.png"; "/*" at the end is any rest
  RunsOn runs_on = RunsOn::kPool;
  std::size_t body_bytes_max = 0;
  std::function<RouteAnswer(const HttpRequest&)> handle;
  /// Called, on the pool, before a body is stored that did not arrive with its header; the request
  /// has no body then. May be empty.
  std::function<Admission(const HttpRequest&)> admit{};
  bool always_admit = false;  ///< call `admit` for every request
  /// Called, on the pool, from time to time while an answer is sent: when it returns false, the
  /// connection is cut. May be empty.
  std::function<bool(const HttpRequest&)> still_may{};
  /// The {name} whose value selects the request's lane in its pool; see PoolLimits. Empty: no lane.
  std::string lane{};
  bool from_anywhere = false;  ///< a page of another site may post here
};

/// Finds the route of a request. Literal segments win over {names}, both over "/*". Immutable while
/// the server runs, so any thread may call it.
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
