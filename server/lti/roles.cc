#include "server/lti/roles.h"

#include <string>

namespace faultlab::server::lti {
namespace {

constexpr std::string_view kMembership =
    "http://purl.imsglobal.org/vocab/lis/v2/membership";  // of a course: "..#Learner"

}  // namespace

bool HasRole(const boost::json::value* roles, std::string_view role) {
  const std::string whole = std::string(kMembership) + "#" + std::string(role);
  const std::string part = std::string(kMembership) + "/" + std::string(role) + "#";
  return Has(roles, [&](std::string_view each) {
    return each == role || each == whole || each.starts_with(part);
  });
}

}  // namespace faultlab::server::lti
