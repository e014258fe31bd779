#pragma once

#include <exception>
#include <stdexcept>
#include <string>
#include <string_view>

#include "core/types/result.h"

namespace faultlab::server {

/// No connection became free in time.
class PoolTimeout : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct TranslatedError {
  core::Error error{};           ///< for a person, without the engine's message
  std::string engine_says{};     ///< for the log: SQL, paths, parameters
  bool connection_lost = false;  ///< the connection must not be used again
};

/// The meaning of a database exception for the caller, and what to do about it. A constraint
/// violation is kConflict, a lock kBusy, disk and damage kUnavailable.
TranslatedError TranslateDatabaseError(const std::exception& exception);

/// Reason of an Error while the database server cannot be reached: the outcome of a write is
/// unknown.
inline constexpr std::string_view kDatabaseAway = "database_away";
/// Whether another try may succeed: the database was busy or away. A full or damaged disk remains
/// so.
bool MayPass(const core::Error& error);

}  // namespace faultlab::server
