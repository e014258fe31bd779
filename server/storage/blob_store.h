#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/storage/database.h"

namespace faultlab::server {

using Bytes = std::vector<std::byte>;

/// Bytes under (owner, sequence). SQLite uses soci::blob. PostgreSQL uses binary libpq, because
/// soci::blob is a large object there, and hex is three times slower. Each function takes part in
/// the caller's transaction and throws what the database throws.
namespace blob_store {

/// Replaces nothing: an existing (owner, sequence) is a constraint violation.
void Put(Transaction& tx,
         const std::string& owner,
         std::int64_t sequence,
         std::span<const std::byte> bytes);
std::optional<Bytes> Get(Transaction& tx, const std::string& owner, std::int64_t sequence);
/// Visits sequences in [from, to) in ascending order, one blob in memory at a time; the visitor
/// returns false to stop.
void ForEach(Transaction& tx,
             const std::string& owner,
             std::int64_t from,
             std::int64_t to,
             const std::function<bool(std::int64_t sequence, const Bytes& bytes)>& visit);
/// The largest sequence <= `at`, if any.
std::optional<std::int64_t> SequenceAtOrBefore(Transaction& tx,
                                               const std::string& owner,
                                               std::int64_t at);
void Erase(Transaction& tx, const std::string& owner);

}  // namespace blob_store
}  // namespace faultlab::server
