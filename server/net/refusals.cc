#include "server/net/refusals.h"

namespace faultlab::server {

HttpResponse PoolFullProblem() {
  return TryAgain(503, "Too many requests are waiting; try again in a second.", 1);
}

HttpResponse CallerFullProblem() {
  return TryAgain(429, "Too many requests of yours are waiting; try again in a second.", 1);
}

HttpResponse SlowBodiesProblem() {
  constexpr int kSeconds = 5;
  return TryAgain(
      429, "Too many requests of yours are half sent; send them to their end first.", kSeconds);
}

HttpResponse BytesFullProblem() {
  constexpr int kSeconds = 5;
  return TryAgain(503, "Too many bytes of others are on their way; try again soon.", kSeconds);
}

HttpResponse PeerProblem(const core::Error& error) {
  constexpr int kSeconds = 3;
  HttpResponse response = Problem(503, error);
  response.headers.emplace_back("Retry-After", std::to_string(kSeconds));
  return response;
}

HttpResponse InternalProblem() {
  return Problem(500,
                 "internal",
                 "Internal error",
                 "The server made a mistake; it is logged. Nothing was changed by this request.");
}

}  // namespace faultlab::server
