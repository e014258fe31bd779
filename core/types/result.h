#pragma once

#include <concepts>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/types/check.h"

namespace faultlab::core {

/// Kinds of expected refusal. One switch in server/api gives the HTTP status.
enum class ErrorCode {
  kInvalid,       ///< the request breaks a rule; `field` names the part
  kNotFound,      ///< it does not exist, or this caller may not see it
  kConflict,      ///< the state has changed since the caller read it
  kUnauthorized,  ///< the caller must sign in first
  kForbidden,     ///< signed in, but not allowed
  kBusy,          ///< no capacity at the moment; try again later, nothing was lost
  kTooMany,       ///< more than this caller may have at once; wait `parameters` "seconds"
  kTooLarge,      ///< more than a stated limit
  kUnavailable,   ///< a rig, disk or database does not answer
  kStale,         ///< an epoch or version older than the current one
};

/// "invalid", "not_found", ..: the word in problem+json and in answers to commands.
constexpr std::string_view Name(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalid:
      return "invalid";
    case ErrorCode::kNotFound:
      return "not_found";
    case ErrorCode::kConflict:
      return "conflict";
    case ErrorCode::kUnauthorized:
      return "unauthorized";
    case ErrorCode::kForbidden:
      return "forbidden";
    case ErrorCode::kBusy:
      return "busy";
    case ErrorCode::kTooMany:
      return "too_many";
    case ErrorCode::kTooLarge:
      return "too_large";
    case ErrorCode::kUnavailable:
      return "unavailable";
    case ErrorCode::kStale:
      return "stale";
  }
  return "?";
}

/// A number or a name in a refusal, which a translation can insert into its own sentence.
struct ErrorParameter {
  ErrorParameter(std::string_view name_, std::string_view text) : name(name_), value(text) {}
  template <std::integral Number>
  requires(sizeof(Number) > 1) ErrorParameter(std::string_view name_, Number number)
      : ErrorParameter(name_, std::to_string(number)) {}
  /// With as few digits as distinguish the number from its neighbours.
  ErrorParameter(std::string_view name_, double number);

  std::string name;   ///< "rig"
  std::string value;  ///< "bench-1"
};

/// An expected refusal: what is wrong and what to do, for a person.
struct Error {
  ErrorCode code = ErrorCode::kInvalid;
  std::string message;
  std::string field;  ///< JSON pointer or column name; empty if the whole request is meant
  /// The reason as a stable word for programs and translations ("rig_needs_session"); `parameters`
  /// has its numbers and names. Empty if the message alone is enough.
  std::string reason{};
  std::vector<ErrorParameter> parameters{};

  /// The same refusal with another code.
  Error As(ErrorCode other) && {
    code = other;
    return std::move(*this);
  }
};

/// The refusal for a reason of core/types/refusals.json, which has its code and its sentence.
Error Refuse(std::string_view reason,
             std::string field = {},
             std::vector<ErrorParameter> parameters = {});

/// A value or an Error. Calling value() on an error is a bug and throws ContractError.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : state_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  bool ok() const { return std::holds_alternative<T>(state_); }
  explicit operator bool() const { return ok(); }

  const T& value() const& {
    LAB_CHECK(ok(), error_text());
    return std::get<T>(state_);
  }
  T& value() & {
    LAB_CHECK(ok(), error_text());
    return std::get<T>(state_);
  }
  T&& value() && {
    LAB_CHECK(ok(), error_text());
    return std::get<T>(std::move(state_));
  }
  const Error& error() const {
    LAB_CHECK(!ok());
    return std::get<Error>(state_);
  }

 private:
  std::string error_text() const { return ok() ? std::string() : std::get<Error>(state_).message; }

  std::variant<T, Error> state_;
};

/// The success of an operation that has no other result.
struct Done {};
using Status = Result<Done>;

}  // namespace faultlab::core

/// TRY(const auto run, store.Get(id)); declares `run` as the value of a Result, or returns its
/// error. TRY_DONE(store.Delete(id)); returns the error of what is wanted for no value.
#define TRY(declaration, ...) LAB_TRY_AS(LAB_JOINED(tried_, __COUNTER__), declaration, __VA_ARGS__)
#define TRY_DONE(...) LAB_TRY_DONE_AS(LAB_JOINED(tried_, __COUNTER__), __VA_ARGS__)

#define LAB_JOINED(first, second) LAB_JOINED_EXPANDED(first, second)
#define LAB_JOINED_EXPANDED(first, second) first##second
#define LAB_TRY_AS(result, declaration, ...) \
  auto&& result = (__VA_ARGS__);             \
  if (!result.ok()) return result.error();   \
  declaration = std::forward<decltype(result)>(result).value()
#define LAB_TRY_DONE_AS(result, ...) \
  if (auto&& result = (__VA_ARGS__); !result.ok()) return result.error()
