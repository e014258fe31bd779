#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace faultlab::server {

/// How many large answers and uploads each caller has on their way: two, and a few that wait for
/// one of them. A browser that stops reading keeps its slots until the connection ends.
/// Thread-safe; places may outlive this.
class TransferQuota {
 public:
  TransferQuota(int per_caller, int waiting_per_caller)
      : per_caller_(per_caller), waiting_per_caller_(waiting_per_caller) {}

  /// A place of this caller, given back when the last copy is gone; null when all are taken.
  std::shared_ptr<void> Take(const std::string& caller) { return Place(caller, per_caller_); }
  /// A place in the line of those that ask again; null when the line is full.
  std::shared_ptr<void> Wait(const std::string& caller) {
    return Place(caller + " waits", waiting_per_caller_);
  }

 private:
  struct Taken {
    std::mutex mutex;
    std::map<std::string, int> of_caller;  ///< callers without a place are not in it
  };
  std::shared_ptr<void> Place(const std::string& key, int places);

  const int per_caller_;
  const int waiting_per_caller_;
  std::shared_ptr<Taken> taken_ = std::make_shared<Taken>();
};

}  // namespace faultlab::server
