#include "server/json/json_reader.h"

#include <boost/json.hpp>
#include <cmath>

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::size_t kDepthMax = 16;
constexpr std::size_t kNameShownMax = 64;

}  // namespace

core::Result<json::object> ParseJsonObject(std::string_view text) {
  if (text.empty()) return json::object{};
  json::parse_options options;
  options.max_depth = kDepthMax;
  boost::system::error_code ec;
  json::value value = json::parse(text, ec, {}, options);
  if (ec) {
    return core::Error{core::ErrorCode::kInvalid,
                       "The body is not JSON: " + ec.message() + ".",
                       {},
                       "body_not_json"};
  }
  if (!value.is_object()) {
    return core::Error{
        core::ErrorCode::kInvalid, "The body must be a JSON object.", {}, "body_not_json"};
  }
  return std::move(value.get_object());
}

bool HasControlCharacter(std::string_view text, std::string_view allowed) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if ((byte < 0x20 || byte == 0x7F) && allowed.find(text[i]) == std::string_view::npos) {
      return true;
    }
    // U+202A..U+202E and U+2066..U+2069: what follows is shown in another order than it is read.
    const std::string_view three = text.substr(i, 3);
    if ((three >= "\xE2\x80\xAA" && three <= "\xE2\x80\xAE") ||
        (three >= "\xE2\x81\xA6" && three <= "\xE2\x81\xA9")) {
      return true;
    }
  }
  return false;
}

std::string ObjectReader::Pointer(std::string_view name) const {
  std::string out = pointer_ + "/";
  for (const char c : name.substr(0, kNameShownMax)) {
    if (c == '~') {
      out.append("~0");
    } else if (c == '/') {
      out.append("~1");
    } else {
      out.push_back(c);
    }
  }
  return out;
}

const json::value* ObjectReader::Find(std::string_view name) {
  asked_.emplace(name);
  return object_.if_contains(name);
}

bool ObjectReader::Has(std::string_view name) {
  return Find(name) != nullptr;
}

void ObjectReader::Refuse(std::string_view name,
                          std::string_view reason,
                          std::vector<core::ErrorParameter> parameters) {
  Refuse(core::Refuse(reason, Pointer(name), std::move(parameters)));
}

void ObjectReader::Refuse(core::Error error) {
  if (!error_) error_ = std::move(error);
}

void ObjectReader::RefuseKind(std::string_view name, const std::string& expected) {
  core::Error error = core::Refuse("kind_wrong", Pointer(name), {{"member", name}});
  error.message = "'" + std::string(name) + "' must be " + expected + ".";
  Refuse(std::move(error));
}

double ObjectReader::Number(std::string_view name, double lo, double hi) {
  if (Find(name) == nullptr) {
    Refuse(name, "member_missing", {{"member", name}});
    return lo;
  }
  return NumberOr(name, lo, lo, hi);
}

double ObjectReader::NumberOr(std::string_view name, double fallback, double lo, double hi) {
  const json::value* value = Find(name);
  if (value == nullptr) return fallback;
  const double number = value->is_number() ? value->to_number<double>() : std::nan("");
  if (std::isfinite(number) && number >= lo && number <= hi) return number;
  Refuse(name, "number_outside", {{"member", name}, {"lowest", lo}, {"highest", hi}});
  return fallback;
}

std::int64_t ObjectReader::Integer(std::string_view name, std::int64_t lo, std::int64_t hi) {
  if (Find(name) == nullptr) {
    Refuse(name, "member_missing", {{"member", name}});
    return lo;
  }
  return IntegerOr(name, lo, lo, hi);
}

std::int64_t ObjectReader::IntegerOr(std::string_view name,
                                     std::int64_t fallback,
                                     std::int64_t lo,
                                     std::int64_t hi) {
  const json::value* value = Find(name);
  if (value == nullptr) return fallback;
  if (value->is_int64() && value->get_int64() >= lo && value->get_int64() <= hi) {
    return value->get_int64();
  }
  Refuse(name, "whole_number_outside", {{"member", name}, {"lowest", lo}, {"highest", hi}});
  return fallback;
}

bool ObjectReader::BooleanOr(std::string_view name, bool fallback) {
  const json::value* value = Find(name);
  if (value == nullptr) return fallback;
  if (value->is_bool()) return value->get_bool();
  RefuseKind(name, "true or false");
  return fallback;
}

std::string ObjectReader::Text(std::string_view name, std::size_t bytes_max) {
  if (Find(name) == nullptr) {
    Refuse(name, "member_missing", {{"member", name}});
    return {};
  }
  return TextOr(name, {}, bytes_max);
}

std::string ObjectReader::TextOr(std::string_view name,
                                 std::string fallback,
                                 std::size_t bytes_max) {
  return ReadText(name, std::move(fallback), bytes_max, "");
}

std::string ObjectReader::ProseOr(std::string_view name,
                                  std::string fallback,
                                  std::size_t bytes_max) {
  return ReadText(name, std::move(fallback), bytes_max, "\n\r\t");
}

std::string ObjectReader::ReadText(std::string_view name,
                                   std::string fallback,
                                   std::size_t bytes_max,
                                   std::string_view allowed) {
  const json::value* value = Find(name);
  if (value == nullptr) return fallback;
  if (value->is_string() && value->get_string().size() <= bytes_max &&
      !HasControlCharacter(value->get_string(), allowed)) {
    return std::string(value->get_string());
  }
  Refuse(name, "text_refused", {{"member", name}, {"most", bytes_max}});
  return fallback;
}

std::string_view ObjectReader::WordOr(std::string_view name,
                                      std::string_view fallback,
                                      std::initializer_list<std::string_view> words) {
  const json::value* value = Find(name);
  if (value == nullptr) return fallback;
  std::string list;
  for (const std::string_view word : words) {
    if (value->is_string() && value->get_string() == word) return word;
    list.append(list.empty() ? "'" : ", '").append(word).append("'");
  }
  Refuse(name, "word_unknown", {{"member", name}, {"words", list}});
  return fallback;
}

const json::object* ObjectReader::ObjectOrNull(std::string_view name) {
  const json::value* value = Find(name);
  if (value == nullptr) return nullptr;
  if (value->is_object()) return &value->get_object();
  RefuseKind(name, "an object");
  return nullptr;
}

const json::array* ObjectReader::ArrayOrNull(std::string_view name, std::size_t size_max) {
  const json::value* value = Find(name);
  if (value == nullptr) return nullptr;
  if (value->is_array() && value->get_array().size() <= size_max) return &value->get_array();
  RefuseKind(name, "a list of at most " + std::to_string(size_max) + " entries");
  return nullptr;
}

std::optional<core::Error> ObjectReader::Finish() {
  if (error_) return error_;
  for (const auto& member : object_) {
    if (asked_.contains(std::string_view(member.key()))) continue;
    std::string known;
    for (const std::string& name : asked_) known.append(known.empty() ? "" : ", ").append(name);
    const std::string shown(member.key().substr(0, kNameShownMax));
    Refuse(member.key(), "member_unknown", {{"member", shown}, {"known", known}});
    break;
  }
  return error_;
}

}  // namespace faultlab::server
