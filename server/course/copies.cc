#include "server/course/copies.h"

#include <boost/json.hpp>
#include <string_view>

#include "server/auth/principal.h"
#include "server/storage/owner_key.h"

namespace faultlab::server::course {
namespace {

namespace json = boost::json;

json::value AccountOf(std::string_view owner) {
  const std::optional<std::int64_t> account = AccountOfOwner(owner);
  return account ? json::value(*account) : json::value(nullptr);
}

}  // namespace

std::vector<Copy> CopiesOf(const Trial& trial) {
  std::vector<Copy> copies;
  const json::value list = json::parse(trial.copies);
  for (const json::value& each : list.as_array()) {
    Copy copy;
    if (!each.at("account").is_null()) copy.account = each.at("account").to_number<std::int64_t>();
    copy.recording = each.at("recording").as_string();
    copy.at = FromMilliseconds(each.at("at_ms").to_number<std::int64_t>());
    copies.push_back(std::move(copy));
  }
  return copies;
}

std::string CopyText(const RunRecord& recording) {
  return json::serialize(json::object{{"account", AccountOf(recording.owner)},
                                      {"recording", recording.id},
                                      {"at_ms", ToMilliseconds(recording.created_at)}});
}

}  // namespace faultlab::server::course
