#pragma once

#include <boost/asio/async_result.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
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

/// Threads for handlers that block. Callers take turns. Work that waits for the same external
/// service is in one lane; lanes take turns as well, so that a stuck lane leaves threads to the
/// others.
class HandlerPool {
 public:
  enum class Room { kFree, kCallerFull, kFull };
  struct Turn {
    std::string caller;
    std::string lane{};
  };

  explicit HandlerPool(PoolLimits limits) : limits_(limits) {}

  void Start();
  /// No more work is accepted.
  void Close();
  /// Waits until the accepted work is done. Call once, after Close().
  void Join();

  /// Whether Run may be called now. Network thread only.
  Room RoomFor(const Turn& turn) const;
  /// Number of tasks that wait for a thread. Any thread.
  std::size_t waiting() const;

  /// Runs `work` on a thread of the pool and returns its result on `io`. Contract: RoomFor(turn) is
  /// kFree.
  template <typename Work>
  boost::asio::awaitable<std::invoke_result_t<Work&>> Run(boost::asio::io_context& io,
                                                          const Turn& turn,
                                                          Work work) {
    namespace asio = boost::asio;
    using Outcome = std::invoke_result_t<Work&>;
    co_return co_await asio::async_initiate<const asio::use_awaitable_t<>, void(Outcome)>(
        [this, &io, &turn, work = std::move(work)](auto handler) mutable {
          using Handler = decltype(handler);
          // std::function needs a copyable task, and a handler is not copyable.
          auto waiting = std::make_shared<Handler>(std::move(handler));
          Push(turn, [&io, work = std::move(work), waiting = std::move(waiting)]() mutable {
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
  struct Lane {
    FairQueue<Task> queue;
    int at_work = 0;
  };
  using Lanes = std::map<std::string, Lane>;

  void Push(const Turn& turn, Task task);
  void Work();
  Lanes::iterator NextLane();

  const PoolLimits limits_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Lanes lanes_;  ///< lanes with work, waiting or running
  std::string last_lane_;
  std::size_t waiting_ = 0;
  bool closed_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace faultlab::server
