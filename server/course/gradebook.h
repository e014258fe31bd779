#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/course/trials.h"

namespace faultlab::server::course {

/// What stands in a gradebook of one student: the attempt that counts, by
/// Rubric::last_counts.
struct GradebookLine {
  std::int64_t account = 0;
  std::string login;
  std::string name;
  int attempts = 0;               ///< those that count: not the void ones
  const Trial* counts = nullptr;  ///< the attempt that counts; null: none has begun
  std::optional<double> points;   ///< 0 .. 100 of it, once it is released
  bool voided = false;            ///< an attempt was void
  double late_percent = 0.0;      ///< taken off them
  bool overridden = false;        ///< they are a teacher's
};

/// A student of the course, or somebody who has left it and has attempts.
struct Student {
  std::int64_t account = 0;
  std::string login;
  std::string name;
};

/// One line a student, in the order of `students`, also of those who never began.
/// @param members  of a trial: who share it
std::vector<GradebookLine> GradebookOf(
    std::span<const Student> students,
    std::span<const Trial> trials,
    bool last_counts,
    const std::function<std::vector<std::int64_t>(const Trial&)>& members);

}  // namespace faultlab::server::course
