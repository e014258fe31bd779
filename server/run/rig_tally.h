#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace faultlab::server {

/// What the rigs of this server have done since somebody took the tally, for those who look after
/// them. Thread-safe.
class RigTally {
 public:
  enum class Event { kTrip, kDeltaStrays };
  struct News {
    Event event = Event::kTrip;
    std::string rig;
    std::string text;
  };
  struct Taken {
    /// By rig and line: how often its relay has closed.
    std::map<std::string, std::map<int, std::int64_t>> closings;
    std::vector<News> news;
  };
  /// More are dropped: they say the same.
  static constexpr std::size_t kNewsMax = 1000;

  void Closed(const std::string& rig, int line);
  void Tell(News news);
  /// What came since the last call.
  Taken Take();

 private:
  std::mutex mutex_;
  Taken taken_;
};

}  // namespace faultlab::server
