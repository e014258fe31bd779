// Target, headers and names of a request after the HTTP parser: routes, percent decoding, queries,
// cookies, hosts.
//   piece target, piece Cookie, piece Host, piece Origin
#include "core/types/utf8.h"
#include "server/auth/cookies.h"
#include "server/net/http.h"
#include "server/net/listen_address.h"
#include "server/net/router.h"
#include "server/net/websocket.h"
#include "tests/fuzz/fuzz_input.h"

using namespace faultlab::server;  // NOLINT(google-build-using-namespace)
using faultlab::fuzz::Require;

namespace {

const Router& Routes() {
  static const Router kRoutes = [] {
    Router router;
    for (const char* pattern : {"/",
                                "/api/v1/runs",
                                "/api/v1/runs/{id}",
                                "/api/v1/runs/{id}/plots/{figure}.png",
                                "/api/v1/calendar/{link}.ics",
                                "/api/v1/rigs/{id}/outages/{outage}",
                                "/files/*"}) {
      for (const HttpMethod method : {HttpMethod::kGet, HttpMethod::kPost}) {
        Route route;
        route.method = method;
        route.pattern = pattern;
        route.handle = [](const HttpRequest&) { return HttpResponse{}; };
        router.Add(std::move(route));
      }
    }
    return router;
  }();
  return kRoutes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  faultlab::fuzz::Input input(data, size);
  HttpRequest request;
  request.method = static_cast<HttpMethod>(input.Byte() % 7);
  request.target = input.Piece();
  // The HTTP parser does not accept such bytes.
  for (const char c : request.target) {
    if (static_cast<unsigned char>(c) <= 0x20 || c == 0x7f) return 0;
  }
  const std::size_t mark = request.target.find('?');
  request.path = request.target.substr(0, mark);
  if (mark != std::string_view::npos) request.query = request.target.substr(mark + 1);
  request.headers = {{"Cookie", input.Piece()}, {"Host", input.Piece()}, {"Origin", input.Piece()}};

  const Router::Match match = Routes().Find(request);
  if (match.route != nullptr) {
    for (const auto& [name, value] : request.path_parameters) {
      Require(value.find('\0') == std::string::npos);
    }
  }
  for (const auto& [name, value] : request.QueryAll()) {
    if (request.Query(name)) Require(name.find('\0') == std::string::npos);
  }
  (void)faultlab::server::CookieValue(request.Header("Cookie"), "faultlab_session");
  const std::string_view host = request.Header("Host");
  (void)HostAllowed(host, {"lab.example"}, true);
  (void)OriginAllowed(request.Header("Origin"), host);
  (void)ParseListenAddress(host);
  (void)websocket::IsValidKey(host);
  (void)faultlab::core::IsUtf8(request.target);
  std::string json;
  AppendJsonString(json, request.target);
  Require(json.size() >= 2 && json.front() == '"' && json.back() == '"');
  const auto decoded = PercentDecode(request.target, true);
  Require(!decoded || decoded->size() <= request.target.size());
  return 0;
}
