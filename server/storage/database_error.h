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
  core::Error error{};           ///< for a person: without the engine's words
  std::string engine_says{};     ///< for the log: SQL, paths, parameters
  bool connection_lost = false;  ///< the connection must not be used again
};

/// What a database exception means for the caller and what to do about it.
/// A constraint violation is kConflict, a lock kBusy, disk and damage kUnavailable.
TranslatedError TranslateDatabaseError(const std::exception& exception);

/// Reason of an Error while the database server cannot be reached: nothing is known of the write.
inline constexpr std::string_view kDatabaseAway = "database_away";
/// Another try may go through: the database was busy, or away. A full or damaged disk stays so.
bool MayPass(const core::Error& error);

}  // namespace faultlab::server
