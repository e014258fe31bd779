#pragma once

#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "server/clock.h"
#include "server/lab/lab_service.h"
#include "server/notify/attempt.h"
#include "server/notify/channel.h"
#include "server/notify/hook_sender.h"
#include "server/notify/news.h"
#include "server/notify/outbox.h"
#include "server/notify/webhooks.h"
#include "server/repeated.h"

namespace faultlab::server::notify {

/// Sends what the outbox holds, from threads of its own: the lab never waits for a receiver.
///
///   lab_event, alarm, lab_booking --Gather, each second--> outbox
///   outbox --Claim--> one of a few threads --HookSender--> Delivered | Retry | GiveUp
///
/// The messages of a channel are sent one by one. A receiver that does not answer rests for 1, 2, 4
/// .. 30 s, in which nothing is sent to it; a message that is refused is tried again after 2, 4, 8
/// .. s, an hour at most.
class Dispatcher {
 public:
  struct Parts {
    Database& database;
    lab::LabService& service;
    const HookSender& hooks;
    const Clock& clock;
    std::function<void(std::string_view)> log;
    std::vector<Channel*> channels{};  ///< besides webhooks
  };
  /// All parts must outlive it.
  Dispatcher(Parts parts, NewsOptions options);
  ~Dispatcher();  ///< Waits for the attempts that are being made.
  Dispatcher(const Dispatcher&) = delete;
  Dispatcher& operator=(const Dispatcher&) = delete;

 private:
  struct Rest {
    int failures = 0;
    MonotonicTime until{};
  };

  void Look();
  void Work();
  core::Result<std::optional<Message>> Claim();
  Attempt Send(const Message& message);
  void Store(const Message& message, const Attempt& attempt);
  std::chrono::milliseconds Note(const std::string& channel, const Attempt& attempt);
  void Log(const core::Error& error);

  const Parts parts_;
  const NewsOptions options_;
  Outbox outbox_;
  Webhooks webhooks_;
  std::mutex claiming_;  ///< taken before mutex_
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  std::uint64_t looks_ = 0;  ///< raised when there is something to send
  std::set<std::string> busy_;
  std::set<std::string> for_people_;  ///< of these
  std::map<std::string, Rest> rests_;
  MonotonicTime tidied_{};
  std::vector<std::thread> workers_;
  std::optional<Repeated> looker_;
};

}  // namespace faultlab::server::notify
