#pragma once

#include <regex.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/signals/random.h"
#include "hardware/lcm/message_bus.h"

namespace faultlab::hardware {

/// The effects of a network on datagrams; probabilities.
struct Weather {
  double loss = 0.0;
  double duplicate = 0.0;
  double reorder = 0.0;  ///< the message waits until another one has overtaken it
};

/// An extended regular expression for whole channel names, as in LCM.
class ChannelPattern {
 public:
  explicit ChannelPattern(const std::string& text) : compiled_(new regex_t) {
    regcomp(compiled_.get(), ("^(" + text + ")$").c_str(), REG_EXTENDED | REG_NOSUB);
  }
  bool Matches(const std::string& channel) const {
    return regexec(compiled_.get(), channel.c_str(), 0, nullptr, 0) == 0;
  }

 private:
  struct Free {
    void operator()(regex_t* compiled) const {
      regfree(compiled);
      delete compiled;
    }
  };
  std::unique_ptr<regex_t, Free> compiled_;
};

/// A bus in memory with several ends and an unreliable connection between them.
class LossyBus {
 public:
  LossyBus(Weather weather, std::uint64_t seed) : weather_(weather), random_(seed) {}

  /// All ends receive all messages, including their own, as with UDP multicast.
  std::unique_ptr<MessageBus> MakeEnd() {
    auto end = std::make_unique<End>(*this);
    const std::lock_guard lock(mutex_);
    ends_.push_back(end.get());
    return end;
  }

  /// While cut, nothing passes between ends.
  void SetCut(bool cut) {
    const std::lock_guard lock(mutex_);
    cut_ = cut;
  }
  /// All published messages, lost or not: those that an attacker may record.
  std::vector<std::pair<std::string, std::vector<std::uint8_t>>> overheard() const {
    const std::lock_guard lock(mutex_);
    return overheard_;
  }
  std::uint64_t lost() const {
    const std::lock_guard lock(mutex_);
    return lost_;
  }

 private:
  class End final : public MessageBus {
   public:
    explicit End(LossyBus& bus) : bus_(bus) {}
    ~End() override { bus_.Leave(this); }
    void Publish(const std::string& channel, Bytes bytes) override {
      bus_.Spread(this, channel, {bytes.begin(), bytes.end()});
    }
    void Subscribe(const std::string& channels, Handler handler) override {
      handlers_.emplace_back(ChannelPattern(channels), std::move(handler));
    }
    void Handle(std::chrono::milliseconds patience) override {
      std::deque<std::pair<std::string, std::vector<std::uint8_t>>> inbox;
      {
        std::unique_lock lock(mutex_);
        filled_.wait_for(lock, patience, [this] { return !inbox_.empty(); });
        inbox.swap(inbox_);
      }
      for (const auto& [channel, bytes] : inbox) {
        for (const auto& [pattern, handler] : handlers_) {
          if (pattern.Matches(channel)) handler(channel, bytes);
        }
      }
    }
    void Put(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
      const std::lock_guard lock(mutex_);
      inbox_.emplace_back(channel, bytes);
      filled_.notify_one();
    }

   private:
    LossyBus& bus_;
    std::vector<std::pair<ChannelPattern, Handler>> handlers_;
    std::mutex mutex_;
    std::condition_variable filled_;
    std::deque<std::pair<std::string, std::vector<std::uint8_t>>> inbox_;
  };

  void Leave(End* end) {
    const std::lock_guard lock(mutex_);
    std::erase(ends_, end);
  }

  void Spread(End* from, const std::string& channel, std::vector<std::uint8_t> bytes) {
    const std::lock_guard lock(mutex_);
    overheard_.emplace_back(channel, bytes);
    for (End* end : ends_) {
      if (end == from) continue;
      if (cut_ || random_.Uniform() < weather_.loss) {
        ++lost_;
        continue;
      }
      if (random_.Uniform() < weather_.reorder) {
        held_.emplace_back(end, std::make_pair(channel, bytes));
        continue;
      }
      end->Put(channel, bytes);
      if (random_.Uniform() < weather_.duplicate) end->Put(channel, bytes);
      for (auto& [late_end, message] : held_) {
        if (std::find(ends_.begin(), ends_.end(), late_end) != ends_.end()) {
          late_end->Put(message.first, message.second);
        }
      }
      held_.clear();
    }
  }

  const Weather weather_;
  mutable std::mutex mutex_;
  core::Random random_;
  std::vector<End*> ends_;
  std::vector<std::pair<End*, std::pair<std::string, std::vector<std::uint8_t>>>> held_;
  std::vector<std::pair<std::string, std::vector<std::uint8_t>>> overheard_;
  bool cut_ = false;
  std::uint64_t lost_ = 0;
};

}  // namespace faultlab::hardware
