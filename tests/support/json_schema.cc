#include "tests/support/json_schema.h"

#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <cctype>
#include <limits>
#include <regex>

namespace faultlab::tests {
namespace {

namespace json = boost::json;

std::string Shown(const json::value& value) {
  std::string text = json::serialize(value);
  if (text.size() > 60) text = text.substr(0, 60) + "..";
  return text;
}

/// Whether "/runs/{id}/plots/{figure}.png" may mean "/runs/7/plots/swa.png": a {name} is never
/// empty and holds no slash.
bool Means(std::string_view pattern, std::string_view path) {
  if (pattern.empty()) return path.empty();
  if (pattern.front() != '{') {
    return !path.empty() && path.front() == pattern.front() &&
           Means(pattern.substr(1), path.substr(1));
  }
  const std::string_view rest = pattern.substr(pattern.find('}') + 1);
  for (std::size_t end = 1; end <= path.size() && path[end - 1] != '/'; ++end) {
    if (Means(rest, path.substr(end))) return true;
  }
  return false;
}

bool HasType(const json::value& value, std::string_view type) {
  if (type == "null") return value.is_null();
  if (type == "boolean") return value.is_bool();
  if (type == "string") return value.is_string();
  if (type == "array") return value.is_array();
  if (type == "object") return value.is_object();
  if (type == "number") return value.is_number();
  if (type == "integer") return value.is_int64() || value.is_uint64();
  return false;
}

bool TypeFits(const json::value& value, const json::value& type) {
  if (type.is_string()) return HasType(value, std::string_view(type.get_string()));
  return std::any_of(type.as_array().begin(), type.as_array().end(), [&](const json::value& one) {
    return HasType(value, std::string_view(one.as_string()));
  });
}

std::optional<std::string> CheckNumber(double value, const json::object& schema) {
  const auto bound = [&](const char* name) { return schema.if_contains(name); };
  if (const auto* low = bound("minimum"); low && value < low->to_number<double>()) {
    return "below minimum";
  }
  if (const auto* high = bound("maximum"); high && value > high->to_number<double>()) {
    return "above maximum";
  }
  if (const auto* low = bound("exclusiveMinimum"); low && value <= low->to_number<double>()) {
    return "not above exclusiveMinimum";
  }
  return std::nullopt;
}

}  // namespace

ApiDescription::ApiDescription(std::string_view openapi_json)
    : document_(json::parse(openapi_json).as_object()) {
  const auto resolve = [this](json::value& value) {
    const json::value* ref = value.as_object().if_contains("$ref");
    if (ref == nullptr) return;
    // "#/components/responses/NotFound"
    const std::string_view name(ref->as_string());
    const std::size_t kind = name.find('/', 2) + 1;
    const std::size_t last = name.find('/', kind) + 1;
    const json::object& components = document_.at("components").as_object();
    const json::value shared =
        components.at(name.substr(kind, last - kind - 1)).at(name.substr(last));
    value = shared;
  };
  for (auto& path : document_.at("paths").as_object()) {
    for (auto& member : path.value().as_object()) {
      json::object& operation = member.value().as_object();
      for (auto& response : operation.at("responses").as_object()) resolve(response.value());
      json::value* const parameters = operation.if_contains("parameters");
      if (parameters == nullptr) continue;
      for (json::value& parameter : parameters->as_array()) resolve(parameter);
    }
  }
}

std::optional<std::string> ApiDescription::CheckSchema(const json::value& value,
                                                       const json::value& schema_value,
                                                       const std::string& at) const {
  const json::object& schema = schema_value.as_object();
  if (const auto* ref = schema.if_contains("$ref")) {
    constexpr std::string_view kPrefix = "#/components/schemas/";
    const std::string_view name = std::string_view(ref->as_string()).substr(kPrefix.size());
    return CheckSchema(value, document_.at("components").at("schemas").at(name), at);
  }
  constexpr std::array<std::string_view, 20> kKnown = {
      "type",     "enum",     "const",   "properties", "required",         "additionalProperties",
      "items",    "oneOf",    "minimum", "maximum",    "exclusiveMinimum", "maxLength",
      "maxItems", "minItems", "pattern", "title",      "description",      "contentEncoding",
      "example",  "minLength"};
  for (const auto& member : schema) {
    if (member.key().starts_with("x-")) continue;  // an extension says nothing of the value
    if (std::find(kKnown.begin(), kKnown.end(), std::string_view(member.key())) == kKnown.end()) {
      return at + ": the checker does not know the keyword " + std::string(member.key());
    }
  }
  const auto wrong = [&](const std::string& what) {
    return at + ": " + what + ": " + Shown(value);
  };
  if (const auto* type = schema.if_contains("type"); type && !TypeFits(value, *type)) {
    return wrong("is not of type " + json::serialize(*type));
  }
  if (const auto* fixed = schema.if_contains("const"); fixed && value != *fixed) {
    return wrong("is not " + json::serialize(*fixed));
  }
  if (const auto* words = schema.if_contains("enum")) {
    const json::array& list = words->as_array();
    if (std::find(list.begin(), list.end(), value) == list.end())
      return wrong("is not in the enum");
  }
  if (const auto* schemas = schema.if_contains("oneOf")) {
    if (auto error = CheckOneOf(value, schemas->as_array(), at)) return error;
  }
  if (value.is_number()) {
    if (auto error = CheckNumber(value.to_number<double>(), schema)) return wrong(*error);
  }
  if (value.is_string()) {
    const std::string text(value.get_string());
    if (const auto* max = schema.if_contains("maxLength");
        max && text.size() > max->to_number<std::size_t>()) {
      return wrong("is too long");
    }
    if (const auto* pattern = schema.if_contains("pattern");
        pattern && !std::regex_search(text, std::regex(std::string(pattern->as_string())))) {
      return wrong("does not match the pattern");
    }
  }
  if (value.is_array()) {
    const json::array& list = value.get_array();
    if (const auto* max = schema.if_contains("maxItems");
        max && list.size() > max->to_number<std::size_t>()) {
      return wrong("has too many items");
    }
    if (const auto* min = schema.if_contains("minItems");
        min && list.size() < min->to_number<std::size_t>()) {
      return wrong("has too few items");
    }
    const auto* items = schema.if_contains("items");
    for (std::size_t i = 0; items != nullptr && i < list.size(); ++i) {
      if (auto error = CheckSchema(list[i], *items, at + "/" + std::to_string(i))) return error;
    }
  }
  if (value.is_object()) return CheckObject(value.get_object(), schema, at);
  return std::nullopt;
}

std::optional<std::string> ApiDescription::CheckOneOf(const json::value& value,
                                                      const json::array& schemas,
                                                      const std::string& at) const {
  int fitting = 0;
  std::string reasons;
  for (const json::value& schema : schemas) {
    const auto error = CheckSchema(value, schema, at);
    if (!error) ++fitting;
    if (error) reasons += "\n  " + *error;
  }
  if (fitting == 1) return std::nullopt;
  return at + ": fits " + std::to_string(fitting) + " of oneOf: " + Shown(value) + reasons;
}

std::optional<std::string> ApiDescription::CheckObject(const json::object& value,
                                                       const json::object& schema,
                                                       const std::string& at) const {
  if (const auto* required = schema.if_contains("required")) {
    for (const json::value& name : required->as_array()) {
      if (!value.contains(std::string_view(name.as_string()))) {
        return at + ": lacks " + std::string(name.as_string());
      }
    }
  }
  const auto* properties = schema.if_contains("properties");
  const auto* additional = schema.if_contains("additionalProperties");
  for (const auto& member : value) {
    const std::string here = at + "/" + std::string(member.key());
    const json::value* known =
        properties != nullptr ? properties->as_object().if_contains(member.key()) : nullptr;
    if (known == nullptr && additional != nullptr) {
      if (additional->is_bool() && !additional->get_bool()) return here + ": is not described";
      if (additional->is_object()) known = additional;
    }
    if (known == nullptr) continue;
    if (auto error = CheckSchema(member.value(), *known, here)) return error;
  }
  return std::nullopt;
}

const json::value* ApiDescription::Operation(std::string_view method,
                                             std::string_view pattern) const {
  std::string lower(method);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  const auto* path = document_.at("paths").as_object().if_contains(pattern);
  return path == nullptr ? nullptr : path->as_object().if_contains(lower);
}

std::optional<std::string> ApiDescription::CheckAnswer(std::string_view method,
                                                       std::string_view pattern,
                                                       int status,
                                                       std::string_view content_type,
                                                       std::string_view body) const {
  const json::value* operation = Operation(method, pattern);
  const std::string name = std::string(method) + " " + std::string(pattern);
  if (operation == nullptr) return name + " is not described";
  const auto* response = operation->at("responses").as_object().if_contains(std::to_string(status));
  if (response == nullptr) {
    return name + ": status " + std::to_string(status) + " is not described: " + std::string(body);
  }
  const auto* content = response->as_object().if_contains("content");
  if (content == nullptr) {
    return body.empty() ? std::nullopt : std::optional<std::string>(name + ": body not described");
  }
  const std::string_view plain = content_type.substr(0, content_type.find(';'));
  const auto* media = content->as_object().if_contains(plain);
  if (media == nullptr) return name + ": content type " + std::string(content_type);
  if (!plain.ends_with("json") || plain == "application/x-ndjson") return std::nullopt;
  boost::system::error_code ec;
  const json::value value = json::parse(body, ec);
  if (ec) return name + ": body is not JSON: " + std::string(body.substr(0, 80));
  const auto error = CheckSchema(value, media->at("schema"));
  if (error) return name + " " + std::to_string(status) + ": " + *error;
  return std::nullopt;
}

std::string ApiDescription::PatternOf(std::string_view target) const {
  const std::string_view path = target.substr(0, target.find('?'));
  std::string best(path);
  std::ptrdiff_t fewest = std::numeric_limits<std::ptrdiff_t>::max();
  for (const auto& [pattern, operations] : document_.at("paths").as_object()) {
    const std::ptrdiff_t names = std::ranges::count(pattern, '{');
    if (names < fewest && Means(pattern, path)) {
      best = pattern;
      fewest = names;
    }
  }
  return best;
}

std::optional<std::string> ApiDescription::CheckRequest(std::string_view method,
                                                        std::string_view pattern,
                                                        std::string_view body) const {
  const json::value* operation = Operation(method, pattern);
  if (operation == nullptr) return std::string(pattern) + " is not described";
  boost::system::error_code ec;
  const json::value value = json::parse(body, ec);
  if (ec) return "not JSON";
  return CheckSchema(
      value, operation->at("requestBody").at("content").at("application/json").at("schema"));
}

}  // namespace faultlab::tests
