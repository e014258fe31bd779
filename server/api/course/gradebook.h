#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/course/trials.h"

namespace faultlab::server {

/// What stands in a gradebook of one student: the attempt that counts, by
/// course::Rubric::last_counts.
struct GradebookLine {
  std::int64_t account = 0;
  std::string login;
  std::string name;
  int attempts = 0;                       ///< those that count: not the void ones
  const course::Trial* counts = nullptr;  ///< the attempt that counts; null: none has begun
  std::optional<double> points;           ///< 0 .. 100 of it, once it is released
  bool voided = false;                    ///< an attempt was void
  double late_percent = 0.0;              ///< taken off them
  bool overridden = false;                ///< they are a teacher's
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
    std::span<const course::Trial> trials,
    bool last_counts,
    const std::function<std::vector<std::int64_t>(const course::Trial&)>& members);

/// Whose columns the file has.
enum class GradebookFor { kAnybody, kExcel, kMoodle, kCanvas };

/// UTF-8, RFC 4180; for Excel with a byte order mark.
///   anybody, Excel: id, login, name, points, percent, attempts, trial, state, late_percent,
///                   overridden, answered_at
///   Moodle: Username (the login), Full name and the exercise; Canvas: its own five columns, the
///           exercise, and the line of points possible. Both would clear what a teacher has entered
///           where a field is empty: who has no points has no line.
std::string GradebookText(std::span<const GradebookLine> lines,
                          const std::string& exercise,
                          GradebookFor whose);

/// Of CSV, without an exponent.
std::string NumberText(double value);
/// A field of CSV in quotes. A spreadsheet takes what begins like a formula for one: such a text
/// gets an apostrophe, as OWASP recommends.
std::string CsvField(const std::string& text);

}  // namespace faultlab::server
