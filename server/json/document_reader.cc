#include "server/json/document_reader.h"

#include <boost/json/value.hpp>
#include <cmath>

namespace faultlab::server {
namespace {

namespace json = boost::json;

const json::object kNoMembers;
const json::array kNoEntries;

}  // namespace

double DocumentReader::Number(std::string_view member, double least) {
  const json::value* value = object_.if_contains(member);
  const bool number = value != nullptr && value->is_number();
  const double read = number ? value->to_number<double>() : 0.0;
  if (!number || !std::isfinite(read) || read < least) {
    Refuse(member, least > 0.0 ? "expected a number above 0" : "expected a number");
  }
  return read;
}

std::optional<double> DocumentReader::NumberOrNull(std::string_view member) {
  const json::value* value = object_.if_contains(member);
  if (value == nullptr || value->is_null()) return std::nullopt;
  if (value->is_number()) return value->to_number<double>();
  Refuse(member, "expected a number or null");
  return std::nullopt;
}

std::string DocumentReader::Text(std::string_view member) {
  const json::value* value = object_.if_contains(member);
  if (value != nullptr && value->is_string()) return std::string(value->get_string());
  Refuse(member, "expected a text");
  return {};
}

bool DocumentReader::Flag(std::string_view member) {
  const json::value* value = object_.if_contains(member);
  if (value != nullptr && value->is_bool()) return value->get_bool();
  Refuse(member, "expected true or false");
  return false;
}

const json::object& DocumentReader::Object(std::string_view member) {
  const json::value* value = object_.if_contains(member);
  if (value != nullptr && value->is_object()) return value->get_object();
  Refuse(member, "expected an object");
  return kNoMembers;
}

const json::array& DocumentReader::Array(std::string_view member) {
  const json::value* value = object_.if_contains(member);
  if (value != nullptr && value->is_array()) return value->get_array();
  Refuse(member, "expected an array");
  return kNoEntries;
}

void DocumentReader::Refuse(std::string_view member, const std::string& message) {
  if (error_) return;
  error_ = core::Error{core::ErrorCode::kInvalid,
                       "member " + prefix_ + std::string(member) + ": " + message,
                       prefix_ + std::string(member),
                       "internal"};
}

const json::object& EntryOf(const json::value& value) {
  return value.is_object() ? value.get_object() : kNoMembers;
}

}  // namespace faultlab::server
