#include "server/net/admission_desk.h"

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

asio::awaitable<Admission> AskAdmission(ConnectionHost& host,
                                        const Route& route,
                                        const HttpRequest& request) {
  Admission admission;
  for (int tries = 1; tries <= kTries; ++tries) {
    admission = {};  // a place in the line is let go before it is asked for again
    if (host.pool.full()) {
      ++host.counters.pool_refused;
      admission.refusal = PoolFullProblem();
      co_return admission;
    }
    admission = co_await host.pool.Run(host.io, [&]() -> Admission {
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
