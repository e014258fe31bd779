#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace faultlab::server {

/// How many large answers and uploads each caller has on their way. A browser that stops reading
/// keeps its slots until the connection ends. Thread-safe; slots may outlive this.
class TransferSlots {
 public:
  explicit TransferSlots(int per_caller) : per_caller_(per_caller) {}

  /// A slot of this caller, given back when the last copy is gone; null when all are taken.
  std::shared_ptr<void> Take(const std::string& caller);
  /// True when Take would give nothing.
  bool Full(const std::string& caller) const;

 private:
  struct Taken {
    std::mutex mutex;
    std::map<std::string, int> of_caller;  ///< callers without a slot are not in it
  };
  const int per_caller_;
  std::shared_ptr<Taken> taken_ = std::make_shared<Taken>();
};

}  // namespace faultlab::server
