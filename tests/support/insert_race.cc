#include "tests/support/insert_race.h"

#include <soci/soci.h>

#include <stdexcept>
#include <thread>

namespace faultlab::tests {
namespace {

using server::Durability;
using server::Transaction;

/// Any number: the trigger waits for this lock, and Run holds it.
constexpr const char* kGate = "77001";

}  // namespace

InsertRace::InsertRace(TestDatabase& database, const std::string& table)
    : gate_(database.OpenAnother()), looker_(database.OpenAnother()) {
  const auto made = gate_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    tx.sql() << std::string(
                    "CREATE FUNCTION wait_at_gate() RETURNS trigger LANGUAGE plpgsql AS "
                    "$body$ BEGIN IF NEW.name LIKE 'first%' THEN "
                    "PERFORM pg_advisory_xact_lock(") +
                    kGate + "); END IF; RETURN NULL; END $body$";
    tx.sql() << "CREATE TRIGGER wait_at_gate AFTER INSERT ON " + table +
                    " FOR EACH ROW EXECUTE FUNCTION wait_at_gate()";
    return core::Done{};
  });
  if (!made.ok()) throw std::runtime_error(made.error().message);
}

bool InsertRace::FirstWaits() {
  int waiting = 0;
  const auto looked = looker_->Read([&](Transaction& tx) -> core::Status {
    tx.sql() << std::string(
                    "SELECT COUNT(*) FROM pg_locks WHERE locktype = 'advisory' AND "
                    "NOT granted AND objid = ") +
                    kGate +
                    " AND database = (SELECT oid FROM pg_database WHERE datname = "
                    "current_database())",
        soci::into(waiting);
    return core::Done{};
  });
  return looked.ok() && waiting > 0;
}

void InsertRace::Run(const std::function<void()>& first, const std::function<void()>& second) {
  std::jthread writer;
  const auto held = gate_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    tx.sql() << std::string("SELECT pg_advisory_xact_lock(") + kGate + ")";
    writer = std::jthread(first);
    while (!FirstWaits()) std::this_thread::yield();
    second();
    return core::Done{};
  });
  if (!held.ok()) throw std::runtime_error(held.error().message);
}

}  // namespace faultlab::tests
