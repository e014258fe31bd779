#include "hardware/lcm/rig_finder.h"

#include <unistd.h>

#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "hardware/clock.h"
#include "hardware/lcm/channels.h"
#include "hardware/lcm/holder_name.h"
#include "hardware/lcm/message_bus.h"
#include "hardware/lcm/remote_rig.h"
#include "hardware/lcm/rig_codec.h"
#include "hardware/lcm/rig_key.h"
#include "hardware/lcm/rig_name.h"

namespace faultlab::hardware {
namespace {

constexpr auto kTurn = std::chrono::milliseconds(5);
/// A bus full of invented names must not fill our memory.
constexpr std::size_t kRigsMax = 10'000;

std::int64_t UnixNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::string Holder(const RigFinderOptions& options) {
  const std::string name = options.server_name.empty() ? "faultlab" : options.server_name;
  const std::string member = name + "-" + std::to_string(RandomId());
  return HolderName(options.lab.empty() ? member : options.lab, member);
}

class Finder final : public RigFinder {
 public:
  Finder(std::unique_ptr<MessageBus> bus, RigFinderOptions options)
      : bus_(std::move(bus)),
        key_directory_(KeyDirectory(options.key_directory)),
        holder_(Holder(options)) {
    bus_->Subscribe("FAULTLAB\\.ANNOUNCE",
                    [this](const std::string&, MessageBus::Bytes bytes) { OnAnnounce(bytes); });
    bus_->Subscribe("FAULTLAB\\..*\\.(REPLY|STREAM)",
                    [this](const std::string& channel, MessageBus::Bytes bytes) {
                      OnRigMessage(channel, bytes);
                    });
    thread_ = std::thread([this] { Loop(); });
  }

  ~Finder() override {
    std::map<std::string, std::shared_ptr<RemoteRig>> rigs;
    {
      const std::lock_guard lock(mutex_);
      rigs = rigs_;
    }
    for (auto& [id, rig] : rigs) {
      if (rig->info().held_by_us) rig->SafeStop("the server ends");
    }
    stop_ = true;
    thread_.join();
  }

  std::vector<RemoteRigInfo> List() const override {
    std::vector<RemoteRigInfo> list;
    const std::lock_guard lock(mutex_);
    for (const auto& [id, rig] : rigs_) list.push_back(rig->info());
    return list;
  }

  std::shared_ptr<Rig> Find(const std::string& id) override {
    const std::lock_guard lock(mutex_);
    const auto found = rigs_.find(id);
    return found == rigs_.end() ? nullptr : found->second;
  }

 private:
  void Loop() {
    while (!stop_) {
      bus_->Handle(kTurn);
      const std::lock_guard lock(mutex_);
      for (auto& [id, rig] : rigs_) rig->Poll();
    }
  }

  void OnAnnounce(MessageBus::Bytes bytes) {
    const std::optional<std::string> name = AnnouncedRig(bytes);
    if (!name || !IsRigName(*name)) return;
    std::shared_ptr<RemoteRig> rig;
    {
      const std::lock_guard lock(mutex_);
      auto found = rigs_.find(*name);
      if (found == rigs_.end()) {
        if (rigs_.size() >= kRigsMax) return;
        const auto key = LoadRigKey(key_directory_, *name);
        RemoteRigSettings settings{.holder = holder_, .key = key.ok() ? key.value() : std::nullopt};
        // A name whose key we have must prove that it is the one.
        const bool foreign = settings.key && IsForeignProtocol(bytes, *settings.key);
        if (!foreign && !ReadAnnouncement(bytes, settings.key)) return;
        auto made = std::make_shared<RemoteRig>(
            *name, bus_, std::move(settings), [clock = clock_] { return clock->Now(); }, UnixNs);
        made->OnAnnounce(bytes);  // described before anybody can find it
        found = rigs_.emplace(*name, std::move(made)).first;
      }
      rig = found->second;
    }
    rig->OnAnnounce(bytes);
  }

  void OnRigMessage(const std::string& channel, MessageBus::Bytes bytes) {
    const std::size_t first = channel.find('.') + 1;
    const std::size_t last = channel.rfind('.');
    std::shared_ptr<RemoteRig> rig;
    {
      const std::lock_guard lock(mutex_);
      const auto found = rigs_.find(channel.substr(first, last - first));
      if (found == rigs_.end()) return;
      rig = found->second;
    }
    if (channel.compare(last, std::string::npos, ".REPLY") == 0) {
      rig->OnReply(bytes);
    } else {
      rig->OnStream(bytes);
    }
  }

  const std::shared_ptr<MessageBus> bus_;
  const std::string key_directory_;
  const std::string holder_;
  const std::shared_ptr<Clock> clock_ = MakeSteadyClock();
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<RemoteRig>> rigs_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace

core::Result<std::unique_ptr<RigFinder>> OpenRigFinder(const RigFinderOptions& options) {
  core::Result<std::unique_ptr<MessageBus>> bus = OpenLcmBus(options.lcm_url);
  if (!bus) return bus.error();
  return std::unique_ptr<RigFinder>(std::make_unique<Finder>(std::move(bus).value(), options));
}

}  // namespace faultlab::hardware
