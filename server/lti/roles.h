#pragma once

#include <boost/json/value.hpp>
#include <string_view>

namespace faultlab::server::lti {

/// Whether a list of texts has one that is `wanted`.
bool Has(const boost::json::value* list, const auto& wanted) {
  if (list == nullptr || !list->is_array()) return false;
  for (const boost::json::value& each : list->get_array()) {
    if (each.is_string() && wanted(std::string_view(each.get_string()))) return true;
  }
  return false;
}

/// Of the course of a link, or a part of it ("membership/Instructor#TeachingAssistant"); what
/// somebody is elsewhere on the platform does not count.
bool HasRole(const boost::json::value* roles, std::string_view role);

}  // namespace faultlab::server::lti
