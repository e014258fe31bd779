#pragma once

#include <cstdint>
#include <optional>

namespace faultlab::hardware {

/// How far an agent's clock is from ours, from requests and their answers: the four times of NTP.
///   offset = ((received - sent) + (replied - back)) / 2,   |error| <= round trip / 2
class ClockOffset {
 public:
  /// @param sent_ns, back_ns          our clock
  /// @param received_ns, replied_ns   the agent's
  void Exchange(std::int64_t sent_ns,
                std::int64_t received_ns,
                std::int64_t replied_ns,
                std::int64_t back_ns);

  /// Agent's time minus ours; nothing before the first exchange.
  const std::optional<double>& offset_s() const { return offset_s_; }
  double round_trip_s() const { return round_trip_s_; }

 private:
  std::optional<double> offset_s_;
  double round_trip_s_ = 0.0;
};

}  // namespace faultlab::hardware
