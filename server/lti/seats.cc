#include "server/lti/seats.h"

#include <boost/json.hpp>

#include "server/course/groups.h"
#include "server/lti/platforms.h"
#include "server/notify/outbox.h"
#include "server/storage/rows.h"

namespace faultlab::server::lti {
namespace {

constexpr const char* kGrade = "grade";
constexpr int kAtOnce = 500;

}  // namespace

template <typename Visit>
void Fields(Seat& seat, Visit&& visit) {
  visit("platform_id", seat.platform);
  visit("assignment_id", seat.assignment);
  visit("account_id", seat.account);
  visit("subject", seat.subject);
  visit("lineitem", seat.lineitem);
}

core::Status Seats::Put(const Seat& seat) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    InsertInto(tx,
               "lti_seat",
               {{"platform_id", seat.platform},
                {"assignment_id", seat.assignment},
                {"account_id", seat.account},
                {"subject", seat.subject},
                {"lineitem", seat.lineitem},
                {"due", 1}},
               "ON CONFLICT (platform_id, assignment_id, account_id) DO UPDATE SET "
               "subject = excluded.subject, lineitem = excluded.lineitem, due = 1");
  });
}

core::Result<std::optional<Seat>> Seats::Find(std::int64_t platform,
                                              std::int64_t assignment,
                                              std::int64_t account) {
  return database_.Read([&](Transaction& tx) {
    return SelectRow<Seat>(
        tx,
        "lti_seat WHERE platform_id = :platform AND assignment_id = :assignment AND "
        "account_id = :account",
        {{"platform", platform}, {"assignment", assignment}, {"account", account}});
  });
}

core::Result<bool> Seats::Gather(WallTime now) {
  const auto due = database_.Read([](Transaction& tx) {
    return CountRows(tx, "(SELECT 1 FROM lti_seat WHERE due = 1 LIMIT 1) AS due_seat");
  });
  if (!due) return due.error();
  if (due.value() == 0) return false;
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<bool> {
    const auto seats =
        SelectRows<Seat>(tx,
                         "lti_seat WHERE due = 1 ORDER BY platform_id, assignment_id, account_id "
                         "LIMIT " +
                             std::to_string(kAtOnce));
    for (const Seat& seat : seats) {
      const std::string channel = NameOf(seat.platform);
      const std::string about =
          boost::json::serialize(boost::json::object{{"assignment", seat.assignment}});
      UpdateWhere(tx,
                  "lti_seat",
                  {{"due", 0}},
                  {{"platform_id", seat.platform},
                   {"assignment_id", seat.assignment},
                   {"account_id", seat.account}});
      // Counted after the seat is written: a release that is not seen here marks it once more.
      const bool has_grade =
          CountRows(tx,
                    "trial WHERE " + course::WithMates(seat.assignment, seat.account) +
                        " AND released_ms > 0") > 0;
      if (!has_grade) continue;
      // One that is being sent may have read the grade before it changed: another follows it.
      const bool waits = UpdateWhere(tx,
                                     "outbox",
                                     {{"created_ms", now}, {"next_ms", now}},
                                     {{"channel", channel},
                                      {"account_id", seat.account},
                                      {"about", about},
                                      {"state", "waiting"},
                                      {"member", ""}}) > 0;
      if (!waits) notify::outbox::Add(tx, channel, seat.account, kGrade, about, now);
    }
    return !seats.empty();
  });
}

}  // namespace faultlab::server::lti
