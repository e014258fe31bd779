#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "server/lab/lab_store.h"

namespace faultlab::server::lab::rehearsal {

/// Thrown out of a turn: the process is dead from here on.
struct Crash {};

/// What happens to the next transaction.
enum class NextWrite : std::uint8_t {
  kStored,
  kRefused,      ///< nothing is stored, and the caller is told so
  kAnswerLost,   ///< it is stored, and the caller is told that the database is away
  kCrashBefore,  ///< the process dies before the commit
  kCrashAfter,   ///< the process dies after the commit
};

/// The faults between one server and its store, set by the rehearsal.
struct StoreFaults {
  bool away = false;  ///< every transaction fails
  NextWrite next = NextWrite::kStored;
  std::int64_t stored = 0;  ///< transactions whose answers were heard
  std::function<void(const std::vector<LabEvent>&)> told{};  ///< messages that were stored
};

/// A store whose connection fails as `faults` says.
class FaultyStore : public LabStore {
 public:
  FaultyStore(std::unique_ptr<LabStore> store, StoreFaults& faults)
      : store_(std::move(store)), faults_(faults) {}

  core::Status Write(const std::function<core::Status(LabTurn&)>& turn) override;
  core::Result<std::vector<LabEvent>> EventsSince(UserId user,
                                                  std::int64_t since,
                                                  int limit) override {
    return store_->EventsSince(user, since, limit);
  }
  bool shared() const override { return store_->shared(); }

 private:
  const std::unique_ptr<LabStore> store_;
  StoreFaults& faults_;
};

}  // namespace faultlab::server::lab::rehearsal
