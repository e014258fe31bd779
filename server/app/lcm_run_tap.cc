#include "server/app/lcm_run_tap.h"

#include <utility>

#include "hardware/lcm/lcm_tap.h"

namespace faultlab::server {
namespace {

class LcmStream : public RunTapStream {
 public:
  LcmStream(hardware::LcmTap& tap,
            const std::string& rig,
            const std::string& run,
            hardware::Epoch epoch)
      : stream_(tap, rig, run, epoch) {}
  void OnFrame(const core::Frame& frame) override { stream_.Publish(frame); }
  void OnEvent(const hardware::RigEvent& event, double t_s) override {
    stream_.Publish(event, t_s);
  }

 private:
  hardware::LcmTap::Stream stream_;
};

class LcmRunTap : public RunTap {
 public:
  explicit LcmRunTap(std::unique_ptr<hardware::LcmTap> tap) : tap_(std::move(tap)) {}
  std::unique_ptr<RunTapStream> Open(const std::string& rig,
                                     const std::string& run,
                                     hardware::Epoch epoch) override {
    return std::make_unique<LcmStream>(*tap_, rig, run, epoch);
  }

 private:
  std::unique_ptr<hardware::LcmTap> tap_;
};

}  // namespace

core::Result<std::unique_ptr<RunTap>> OpenLcmRunTap(const std::string& url) {
  TRY(auto tap, hardware::LcmTap::Open(url));
  std::unique_ptr<RunTap> out = std::make_unique<LcmRunTap>(std::move(tap));
  return out;
}

}  // namespace faultlab::server
