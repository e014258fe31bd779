#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "core/diagnosis/diagnosis.h"

namespace faultlab::server {

/// Diagnoses of ended runs, the newest used kept: a page asks for four figures of a run, and the
/// fits behind them are made once. An ended run does not change, so nothing goes stale.
/// Thread-safe. Two threads that ask for the same run at once may both make it.
class DiagnosisCache {
 public:
  explicit DiagnosisCache(std::size_t runs_max = 64) : runs_max_(runs_max) {}

  using Shared = std::shared_ptr<const core::Diagnosis>;
  Shared Get(std::string_view run, const std::function<core::Diagnosis()>& make);

 private:
  using Order = std::list<std::pair<std::string, Shared>>;  ///< the last used in front
  const std::size_t runs_max_;
  std::mutex mutex_;
  Order order_;
  std::unordered_map<std::string, Order::iterator> by_run_;
};

}  // namespace faultlab::server
