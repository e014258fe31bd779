#include "server/net/admission.h"

#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <exception>
#include <string>

#include "server/net/refusals.h"

namespace faultlab::server {
namespace {

namespace asio = boost::asio;

constexpr int kTries = 60;
constexpr std::chrono::milliseconds kPause{500};

}  // namespace

std::optional<HttpResponse> PoolRefusal(ConnectionHost& host,
                                        const HandlerPool& pool,
                                        const HandlerPool::Turn& turn) {
  const HandlerPool::Room room = pool.RoomFor(turn);
  if (room == HandlerPool::Room::kFree) return std::nullopt;
  ++host.counters.pool_refused;
  return room == HandlerPool::Room::kCallerFull ? CallerFullProblem() : PoolFullProblem();
}

asio::awaitable<Admission> AskAdmission(ConnectionHost& host,
                                        const Route& route,
                                        const HttpRequest& request,
                                        const std::string& caller) {
  Admission admission;
  const HandlerPool::Turn turn{caller};
  for (int tries = 1; tries <= kTries; ++tries) {
    admission = {};  // releases a place in a queue before asking again
    if (auto full = PoolRefusal(host, host.pool, turn)) {
      admission.refusal = std::move(*full);
      co_return admission;
    }
    admission = co_await host.pool.Run(host.io, turn, [&]() -> Admission {
      try {
        return route.admit(request);
      } catch (const std::exception& error) {
        host.Report(std::string("admission to ") + route.pattern + ": " + error.what());
        return {.refusal = InternalProblem()};
      }
    });
    if (!admission.not_yet || tries == kTries) break;
    asio::steady_timer pause(host.io, kPause);
    boost::system::error_code ec;
    co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, ec));
  }
  co_return admission;
}

}  // namespace faultlab::server
