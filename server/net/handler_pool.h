#pragma once

#include <atomic>
#include <boost/asio/async_result.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cstddef>
#include <optional>
#include <type_traits>
#include <utility>

namespace faultlab::server {

/// The threads on which handlers run that block. Of the network thread but for waiting().
class HandlerPool {
 public:
  explicit HandlerPool(std::size_t waiting_max) : waiting_max_(waiting_max) {}

  void Start(int threads) { threads_.emplace(static_cast<std::size_t>(threads)); }
  /// Nothing more is taken.
  void Close() { closed_ = true; }
  /// What was taken is done. Any thread, once, behind Close().
  void Join() { threads_->join(); }

  bool full() const { return closed_ || waiting_ >= waiting_max_; }
  /// How many wait for a thread. Any thread.
  std::size_t waiting() const { return waiting_; }

  /// Runs `work` on a thread of the pool and gives what it returns, back on `io`. The pool must not
  /// be full.
  template <typename Work>
  boost::asio::awaitable<std::invoke_result_t<Work&>> Run(boost::asio::io_context& io, Work work) {
    namespace asio = boost::asio;
    using Outcome = std::invoke_result_t<Work&>;
    ++waiting_;
    co_return co_await asio::async_initiate<const asio::use_awaitable_t<>, void(Outcome)>(
        [this, &io, work = std::move(work)](auto handler) mutable {
          asio::post(*threads_,
                     [this, &io, work = std::move(work), handler = std::move(handler)]() mutable {
                       --waiting_;
                       Outcome outcome = work();
                       asio::post(
                           io,
                           [handler = std::move(handler), outcome = std::move(outcome)]() mutable {
                             std::move(handler)(std::move(outcome));
                           });
                     });
        },
        asio::use_awaitable);
  }

 private:
  const std::size_t waiting_max_;
  std::atomic<std::size_t> waiting_{0};
  bool closed_ = false;
  std::optional<boost::asio::thread_pool> threads_;
};

}  // namespace faultlab::server
