#pragma once

#include <chrono>
#include <cstddef>
#include <list>
#include <map>
#include <mutex>
#include <string>

#include "server/clock.h"

namespace faultlab::server {

/// Who waits for a simulator of a bench, in the order in which they asked first. Whoever does not
/// ask again within three times AgainAfter is away: others pass, and the place is kept for
/// kKeptFor, because a browser lets a page that nobody looks at ask once a minute. Thread-safe.
class WaitingLine {
 public:
  /// Often enough for who is next, and seldom enough for a class of 250.
  static constexpr std::chrono::seconds AgainAfter(std::size_t before) {
    return std::chrono::seconds(before < 80 ? 2 + before / 10 : 10);
  }
  /// Of a bench: who asks beyond is not remembered.
  static constexpr std::size_t kLongest = 2000;

  static constexpr std::chrono::minutes kKeptFor{3};

  /// How many present ones stand before this caller, who joins the line at its end when they are
  /// not in it.
  std::size_t Ask(const std::string& bench, const std::string& caller, MonotonicTime now);
  void Leave(const std::string& bench, const std::string& caller);
  /// Of those who are present.
  std::size_t Length(const std::string& bench, MonotonicTime now);

 private:
  struct Waiting {
    std::string caller;
    MonotonicTime until{};  ///< then it is away
  };
  std::list<Waiting>& LineOf(const std::string& bench, MonotonicTime now);

  std::mutex mutex_;
  std::map<std::string, std::list<Waiting>> lines_;
};

}  // namespace faultlab::server
