#include "hardware/lcm/rig_finder.h"

#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "hardware/clock.h"
#include "hardware/lcm/holder_name.h"
#include "hardware/lcm/key_ring.h"
#include "hardware/lcm/message_bus.h"
#include "hardware/lcm/remote_rig.h"
#include "hardware/lcm/rig_codec.h"
#include "hardware/lcm/rig_key.h"
#include "hardware/lcm/rig_name.h"
#include "hardware/lcm/sealed_message.h"
#include "hardware/lcm/unproven_rigs.h"

namespace faultlab::hardware {
namespace {

constexpr auto kListenTurn = std::chrono::milliseconds(5);

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
      : bus_(std::move(bus)), keys_(KeyDirectory(options.key_directory)), holder_(Holder(options)) {
    bus_->Subscribe("FAULTLAB\\.ANNOUNCE",
                    [this](const std::string&, MessageBus::Bytes bytes) { OnAnnounce(bytes); });
    bus_->Subscribe("FAULTLAB\\..*\\.(BENCH|REPLY|STREAM)",
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
    for (const auto& [id, rig] : rigs_) {
      if (rig->IsDescribed()) list.push_back(rig->info());
    }
    return list;
  }

  std::vector<RemoteRigInfo> Unkeyed() const override {
    std::vector<RemoteRigInfo> list;
    const Nanoseconds now = clock_->Now();
    const std::lock_guard lock(mutex_);
    for (const UnprovenRigs::Name& heard : unkeyed_.List(now)) {
      RemoteRigInfo info;
      info.description.id = heard.name;
      info.description.kind = RigKind::kRemote;
      info.silent_s = std::chrono::duration<double>(now - heard.heard_at).count();
      info.refusal = heard.why;
      info.refusal_text = RefusalText(heard.why);
      list.push_back(std::move(info));
    }
    for (const auto& [id, rig] : rigs_) {
      if (rig->IsDescribed()) continue;
      RemoteRigInfo info = rig->info();
      const std::string why = rig->bench_refusal();
      if (!why.empty() || !info.refusal) {
        info.refusal = why.empty() ? RigRefusal::kBenchAwaited : RigRefusal::kBenchUnreadable;
        info.refusal_text = RefusalText(*info.refusal, why);
      }
      list.push_back(std::move(info));
    }
    return list;
  }

  std::shared_ptr<Rig> Find(const std::string& id) override {
    const auto rig = KnownRig(id);
    return rig != nullptr && rig->IsDescribed() ? rig : nullptr;
  }

 private:
  void Loop() {
    while (!stop_) {
      bus_->Handle(kListenTurn);
      const std::lock_guard lock(mutex_);
      for (auto& [id, rig] : rigs_) rig->Poll();
    }
  }

  void OnAnnounce(MessageBus::Bytes bytes) {
    const std::optional<std::string> name = SealedRig(bytes);
    if (!name || !IsRigName(*name)) return;
    const Nanoseconds now = clock_->Now();
    const auto rig = KnownRig(*name);
    if (rig != nullptr && rig->OnAnnounce(bytes)) {
      if (!rig->AnnouncesAnotherBench()) return;
      const std::lock_guard lock(mutex_);
      MakeRig(*name, rig->key(), bytes);
      return;
    }
    const std::optional<RigKey> key = keys_.Find(*name, now);
    if (rig != nullptr && key == rig->key()) return;  // it is silent, or this is not its name
    const bool proved = key && (ReadAnnouncement(bytes, *name, *key).has_value() ||
                                IsForeignProtocol(bytes, *name, *key));
    if (rig != nullptr && !proved) return;
    if (rig != nullptr) rig->GiveUp("the rig has another key now");
    const std::lock_guard lock(mutex_);
    if (!proved) {
      unkeyed_.Hear(*name, key ? RigRefusal::kOtherKey : RigRefusal::kNoKey, now);
      return;
    }
    unkeyed_.Remove(*name);
    MakeRig(*name, *key, bytes);
  }

  /// In the place of the one that was built otherwise, if there is one: whoever holds that sees its
  /// run end. Call with mutex_ held.
  void MakeRig(const std::string& name, const RigKey& key, MessageBus::Bytes announcement) {
    auto rig = std::make_shared<RemoteRig>(
        name,
        bus_,
        RemoteRigSettings{.holder = holder_, .key = key},
        [clock = clock_] { return clock->Now(); },
        UnixNs);
    rig->OnAnnounce(announcement);
    rigs_[name] = std::move(rig);
  }

  std::shared_ptr<RemoteRig> KnownRig(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    const auto found = rigs_.find(name);
    return found == rigs_.end() ? nullptr : found->second;
  }

  void OnRigMessage(const std::string& channel, MessageBus::Bytes bytes) {
    const std::size_t first = channel.find('.') + 1;
    const std::size_t last = channel.rfind('.');
    const auto rig = KnownRig(channel.substr(first, last - first));
    if (rig == nullptr) return;
    if (channel.compare(last, std::string::npos, ".REPLY") == 0) {
      rig->OnReply(bytes);
    } else if (channel.compare(last, std::string::npos, ".BENCH") == 0) {
      rig->OnBench(bytes);
    } else {
      rig->OnStream(bytes);
    }
  }

  const std::shared_ptr<MessageBus> bus_;
  KeyRing keys_;  ///< of the bus thread
  const std::string holder_;
  const std::shared_ptr<Clock> clock_ = MakeSteadyClock();
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<RemoteRig>> rigs_;  ///< as many as there are keys
  UnprovenRigs unkeyed_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace

core::Result<std::unique_ptr<RigFinder>> OpenRigFinder(const RigFinderOptions& options) {
  TRY(auto bus, OpenLcmBus(options.lcm_url));
  return std::unique_ptr<RigFinder>(std::make_unique<Finder>(std::move(bus), options));
}

}  // namespace faultlab::hardware
