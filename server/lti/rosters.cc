#include "server/lti/rosters.h"

#include <boost/json.hpp>

#include "server/lti/roles.h"
#include "server/oidc/claims.h"
#include "server/oidc/provider_documents.h"
#include "server/storage/rows.h"

namespace faultlab::server::lti {

template <typename Visit>
void Fields(Roster& roster, Visit&& visit) {
  visit("platform_id", roster.platform);
  visit("course_id", roster.course);
  visit("url", roster.url);
}

namespace {

namespace json = boost::json;
using oidc::TextOf;

constexpr const char* kAccept =
    "Accept: application/vnd.ims.lti-nrps.v2.membershipcontainer+json, application/json;q=0.5";
constexpr const char* kPage = "limit=100";
constexpr int kPagesMax = 500;
constexpr int kNotThere = 404;
constexpr int kGone = 410;

core::Error Silent(const std::string& what) {
  return core::Refuse("platform_silent", "", {{"what", what}});
}

/// Of a header Link (RFC 8288), the address of the next page; some platforms quote the relation
/// with typographic marks, or not at all.
std::string NextOf(std::string_view links) {
  for (std::size_t from = links.find('<'); from != std::string_view::npos;) {
    const std::size_t end = links.find('>', from);
    if (end == std::string_view::npos) break;
    const std::size_t after = links.find('<', end);
    const std::string_view about = links.substr(end, after - end);
    const std::size_t relation = about.find("rel");
    if (relation != std::string_view::npos && about.find("next", relation) != about.npos) {
      return std::string(links.substr(from + 1, end - from - 1));
    }
    from = after;
  }
  return {};
}

std::string ShownName(const json::object& member) {
  if (std::string name = TextOf(member, "name"); !name.empty()) return name;
  const std::string given = TextOf(member, "given_name");
  const std::string family = TextOf(member, "family_name");
  return given + (given.empty() || family.empty() ? "" : " ") + family;
}

std::string ProposedLogin(const json::object& member) {
  std::string login = TextOf(member, "ext_user_username");
  return login.empty() ? TextOf(member, "lis_person_sourcedid") : login;
}

void AddStudents(const json::array& members, std::vector<RosterStudent>& students) {
  for (const json::value& each : members) {
    const json::object* member = each.if_object();
    if (member == nullptr || !HasRole(member->if_contains("roles"), "Learner") ||
        HasRole(member->if_contains("roles"), "Instructor")) {
      continue;
    }
    const std::string status = TextOf(*member, "status");  // none: active
    std::string subject = TextOf(*member, "user_id");
    if (subject.empty() || !(status.empty() || status == "Active")) continue;
    students.push_back({std::move(subject), ProposedLogin(*member), ShownName(*member)});
  }
}

Parameters KeyOf(const Roster& roster) {
  return {{"platform_id", roster.platform}, {"course_id", roster.course}, {"url", roster.url}};
}

}  // namespace

core::Status Rosters::Forget(const Roster& roster) {
  return database_.Write(Durability::kPromise,
                         [&](Transaction& tx) { DeleteFrom(tx, "lti_roster", KeyOf(roster)); });
}

core::Status Rosters::Put(const Roster& roster) {
  const Parameters key = KeyOf(roster);
  const auto known = database_.Read([&](Transaction& tx) {
    return CountRows(tx,
                     "lti_roster WHERE platform_id = :platform_id AND course_id = :course_id AND "
                     "url = :url",
                     key);
  });
  if (!known) return known.error();
  if (known.value() > 0) return core::Done{};
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    InsertInto(tx, "lti_roster", key, "ON CONFLICT (platform_id, course_id, url) DO NOTHING");
  });
}

core::Result<std::vector<Roster>> Rosters::Of(std::int64_t course) {
  return database_.Read([&](Transaction& tx) {
    return SelectRows<Roster>(
        tx, "lti_roster WHERE course_id = :course ORDER BY platform_id, url", {{"course", course}});
  });
}

core::Result<std::vector<RosterStudent>> Rosters::Read(const Platform& platform,
                                                       const Roster& roster,
                                                       MonotonicTime until) {
  std::vector<RosterStudent> students;
  std::string url = roster.url + (roster.url.find('?') == std::string::npos ? "?" : "&") + kPage;
  for (int page = 0; !url.empty(); ++page) {
    // The token goes where the first page is, and nowhere else.
    if (clock_.Monotonic() > until) return Silent("it takes longer than a minute");
    if (page >= kPagesMax || OriginOf(url) != OriginOf(roster.url)) {
      return Silent("its list of people does not end");
    }
    const auto answer = client_.AskAs(platform, kRosterScope, {url, {kAccept}});
    if (!answer) return Silent(answer.error().message);
    const int status = answer.value().status;
    if (page == 0 && (status == kGone || status == kNotThere)) return core::Refuse("no_roster");
    const auto read = oidc::ObjectOf(answer.value(), "the platform's list of people");
    if (!read) return Silent(read.error().message);
    const json::value* members = read.value().if_contains("members");
    if (members == nullptr || !members->is_array()) return Silent("its list has no members");
    AddStudents(members->get_array(), students);
    if (students.size() > kStudentsMax)
      return core::Refuse("course_full", "", {{"most", kStudentsMax}});
    url = NextOf(answer.value().link);
  }
  return students;
}

}  // namespace faultlab::server::lti
