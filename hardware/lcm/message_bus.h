#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "core/types/result.h"

namespace faultlab::hardware {

/// Bytes by channel, no promise of delivery, order or sender.
class MessageBus {
 public:
  using Bytes = std::span<const std::uint8_t>;
  using Handler = std::function<void(const std::string& channel, Bytes bytes)>;

  virtual ~MessageBus() = default;
  /// From any thread. A message that the bus does not take is lost like any other.
  virtual void Publish(const std::string& channel, Bytes bytes) = 0;
  /// `channels` is a regular expression. Before the first Handle.
  virtual void Subscribe(const std::string& channels, Handler handler) = 0;
  /// Calls handlers for what is there, waiting up to `patience` for the first. One thread. What a
  /// handler throws comes out here.
  virtual void Handle(std::chrono::milliseconds patience) = 0;
};

/// LCM by URL (bus_url.h). kInvalid for another kind of URL; kUnavailable, with what to do, when it
/// does not open.
core::Result<std::unique_ptr<MessageBus>> OpenLcmBus(const std::string& url);

}  // namespace faultlab::hardware
