#pragma once

#include <boost/json/value.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace faultlab::tests {

/// Checks values against an OpenAPI 3.1 description: the part of JSON Schema that it uses ($ref
/// into components, type, enum, const, properties, required, additionalProperties, items, oneOf,
/// minimum, maximum, exclusiveMinimum, maxLength, minItems, maxItems, pattern).
/// An unknown keyword is an error too, so that no part of the description remains unchecked.
class ApiDescription {
 public:
  /// Responses and parameters that operations share by $ref stand in their place afterwards.
  explicit ApiDescription(std::string_view openapi_json);

  /// The error, with the path of the value; nullopt if the value fits.
  std::optional<std::string> CheckSchema(const boost::json::value& value,
                                         const boost::json::value& schema,
                                         const std::string& at = "") const;
  /// Checks an answer of `method path-pattern`: status, content type and (for JSON) body.
  std::optional<std::string> CheckAnswer(std::string_view method,
                                         std::string_view pattern,
                                         int status,
                                         std::string_view content_type,
                                         std::string_view body) const;
  /// Checks a JSON request body.
  std::optional<std::string> CheckRequest(std::string_view method,
                                          std::string_view pattern,
                                          std::string_view body) const;

  /// The path of the description that a target means: "/api/v1/runs/{id}" for "/api/v1/runs/7?x=1",
  /// that with the fewest {names} where several do. The target itself where none does.
  std::string PatternOf(std::string_view target) const;

  const boost::json::object& document() const { return document_; }

 private:
  const boost::json::value* Operation(std::string_view method, std::string_view pattern) const;
  std::optional<std::string> CheckObject(const boost::json::object& value,
                                         const boost::json::object& schema,
                                         const std::string& at) const;
  std::optional<std::string> CheckOneOf(const boost::json::value& value,
                                        const boost::json::array& schemas,
                                        const std::string& at) const;

  boost::json::object document_;
};

}  // namespace faultlab::tests
