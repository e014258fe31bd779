#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace faultlab::server::lti {

/// What a link on a platform says in its custom parameter `exercise`: which one, sealed. It is an
/// invitation: whoever puts it on a registered platform lets the people there into the course.
///
/// @param secret  shared by the servers of a database
std::string ExerciseCode(std::int64_t assignment, std::string_view secret);
/// nullopt: not made with this secret.
std::optional<std::int64_t> ExerciseOf(std::string_view code, std::string_view secret);

}  // namespace faultlab::server::lti
