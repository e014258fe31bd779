#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "core/types/frame.h"
#include "core/types/result.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// Publishes what runs see on an LCM bus, for lcm-logger, lcm-spy and whoever listens:
///   FAULTLAB.<rig>.SAMPLE     faultlab_msgs::sample_t
///   FAULTLAB.<rig>.ESTIMATES  faultlab_msgs::estimates_t, the six estimators
///   FAULTLAB.<rig>.EVENT      faultlab_msgs::event_t
/// LCM loses silently; each channel counts `seq` from 0 per run, so that a listener sees its gaps.
class LcmTap {
 public:
  /// One run's voice on the bus. One thread; must not outlive its tap.
  class Stream {
   public:
    Stream(LcmTap& tap, std::string rig, std::string run, Epoch epoch);
    void Publish(const core::Frame& frame);
    void Publish(const RigEvent& event, double t_s);

   private:
    LcmTap& tap_;
    const std::string rig_;
    const std::string run_;
    const Epoch epoch_;
    const std::string sample_channel_;
    const std::string estimates_channel_;
    const std::string event_channel_;
    std::int64_t samples_ = 0;
    std::int64_t estimates_ = 0;
    std::int64_t events_ = 0;
  };

  /// @param url  "udpm://239.255.76.67:7667?ttl=0", "memq://", "file://run.lcm?mode=w"
  /// kInvalid for another kind of URL; kUnavailable with what to do when the bus does not open.
  static core::Result<std::unique_ptr<LcmTap>> Open(const std::string& url);
  ~LcmTap();

  /// Messages that the bus took, and that it refused. LCM itself tells of no loss behind that.
  std::uint64_t published() const { return published_; }
  std::uint64_t failed() const { return failed_; }

 private:
  struct Bus;
  explicit LcmTap(std::unique_ptr<Bus> bus);

  std::unique_ptr<Bus> bus_;
  std::atomic<std::uint64_t> published_{0};
  std::atomic<std::uint64_t> failed_{0};
};

}  // namespace faultlab::hardware
