#pragma once

#include <boost/json/parse.hpp>
#include <boost/json/value.hpp>
#include <string>
#include <string_view>

// Reading JSON that this program stored, where what is damaged or missing is nothing.
namespace faultlab::server {

/// `fallback` where the text is not JSON.
inline boost::json::value ParsedOr(std::string_view text, boost::json::value fallback = nullptr) {
  boost::system::error_code failed;
  boost::json::value value = boost::json::parse(text, failed);
  return failed ? fallback : value;
}

/// Null where `value` is no object or lacks the member.
inline const boost::json::value* MemberIn(const boost::json::value& value, std::string_view name) {
  const boost::json::object* object = value.if_object();
  return object != nullptr ? object->if_contains(name) : nullptr;
}

/// Empty where that is no text.
inline std::string TextIn(const boost::json::value& value, std::string_view name) {
  const boost::json::value* member = MemberIn(value, name);
  return member != nullptr && member->is_string() ? std::string(member->get_string())
                                                  : std::string();
}

}  // namespace faultlab::server
