#pragma once

#include <boost/asio/async_result.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/net/fair_queue.h"
#include "server/net/pool_limits.h"

namespace faultlab::server {

/// Threads on which handlers run that block. Callers take turns.
class HandlerPool {
 public:
  enum class Room { kFree, kCallerFull, kFull };

  explicit HandlerPool(PoolLimits limits) : limits_(limits) {}

  void Start();
  /// Nothing more is taken.
  void Close();
  /// What was taken is done. Once, behind Close().
  void Join();

  /// Whether Run may be called now. Of the network thread.
  Room RoomFor(const std::string& caller) const;
  /// How many wait for a thread. Any thread.
  std::size_t waiting() const;

  /// Runs `work` on a thread of the pool and gives what it returns, back on `io`. Contract:
  /// RoomFor(caller) is kFree.
  template <typename Work>
  boost::asio::awaitable<std::invoke_result_t<Work&>> Run(boost::asio::io_context& io,
                                                          const std::string& caller,
                                                          Work work) {
    namespace asio = boost::asio;
    using Outcome = std::invoke_result_t<Work&>;
    co_return co_await asio::async_initiate<const asio::use_awaitable_t<>, void(Outcome)>(
        [this, &io, &caller, work = std::move(work)](auto handler) mutable {
          using Handler = decltype(handler);
          // std::function wants a copyable task, and a handler is not.
          auto waiting = std::make_shared<Handler>(std::move(handler));
          Push(caller, [&io, work = std::move(work), waiting = std::move(waiting)]() mutable {
            Outcome outcome = work();
            asio::post(io, [waiting = std::move(waiting), outcome = std::move(outcome)]() mutable {
              std::move (*waiting)(std::move(outcome));
            });
          });
        },
        asio::use_awaitable);
  }

 private:
  using Task = std::function<void()>;
  void Push(const std::string& caller, Task task);
  void Work();

  const PoolLimits limits_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  FairQueue<Task> queue_;
  bool closed_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace faultlab::server
