#include "hardware/lcm/lcm_tap.h"

#include <chrono>
#include <lcm/lcm-cpp.hpp>
#include <utility>

#include "hardware/lcm/bus_url.h"
#include "hardware/lcm/message_codec.h"

namespace faultlab::hardware {

/// Only sends: liblcm opens its receiving socket and thread at the first subscription, and none is
/// made here.
struct LcmTap::Bus {
  explicit Bus(const std::string& url) : lcm(url) {}

  template <typename Message>
  void Publish(LcmTap& tap, const std::string& channel, const Message& message) {
    // Not 0 is all that LCM says.
    if (lcm.publish(channel, &message) == 0) {
      ++tap.published_;
    } else {
      ++tap.failed_;
    }
  }

  lcm::LCM lcm;
};

core::Result<std::unique_ptr<LcmTap>> LcmTap::Open(const std::string& url) {
  if (const core::Status status = CheckBusUrl(url); !status) return status.error();
  auto bus = std::make_unique<Bus>(url);
  if (!bus->lcm.good()) return BusDoesNotOpen(url, "");
  return std::unique_ptr<LcmTap>(new LcmTap(std::move(bus)));
}

LcmTap::LcmTap(std::unique_ptr<Bus> bus) : bus_(std::move(bus)) {}
LcmTap::~LcmTap() = default;

LcmTap::Stream::Stream(LcmTap& tap, std::string rig, std::string run, Epoch epoch)
    : tap_(tap),
      rig_(std::move(rig)),
      run_(std::move(run)),
      epoch_(epoch),
      sample_channel_("FAULTLAB." + rig_ + ".SAMPLE"),
      estimates_channel_("FAULTLAB." + rig_ + ".ESTIMATES"),
      event_channel_("FAULTLAB." + rig_ + ".EVENT") {}

void LcmTap::Stream::Publish(const core::Frame& frame) {
  faultlab_msgs::sample_t sample;
  sample.rig = rig_;
  sample.run = run_;
  sample.epoch = static_cast<std::int64_t>(epoch_);
  sample.seq = samples_++;
  sample.sent_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
                       std::chrono::system_clock::now().time_since_epoch())
                       .count();
  Encode(frame.sample, sample);
  tap_.bus_->Publish(tap_, sample_channel_, sample);

  faultlab_msgs::estimates_t estimates;
  estimates.rig = rig_;
  estimates.run = run_;
  estimates.seq = estimates_++;
  Encode(frame, estimates);
  tap_.bus_->Publish(tap_, estimates_channel_, estimates);
}

void LcmTap::Stream::Publish(const RigEvent& event, double t_s) {
  faultlab_msgs::event_t out;
  out.rig = rig_;
  out.run = run_;
  out.seq = events_++;
  out.t_s = t_s;
  Encode(event, out);
  tap_.bus_->Publish(tap_, event_channel_, out);
}

}  // namespace faultlab::hardware
