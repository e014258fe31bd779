#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace faultlab::server {

/// One thread that does work in the given order. It runs live commands, so that neither the network
/// nor the hub waits for a rig.
class CommandWorker {
 public:
  explicit CommandWorker(std::size_t waiting_max);
  ~CommandWorker();  ///< does the queued work first
  CommandWorker(const CommandWorker&) = delete;
  CommandWorker& operator=(const CommandWorker&) = delete;

  /// False when `waiting_max` tasks already wait.
  bool Submit(std::function<void()> work);

 private:
  void Loop();

  const std::size_t waiting_max_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> queue_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace faultlab::server
