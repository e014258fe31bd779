#pragma once

#include <span>
#include <string>

#include "server/course/gradebook.h"

namespace faultlab::server {

/// Whose columns the file has.
/// kExcelComma: an Excel whose numbers have a decimal comma, and whose lists semicolons.
enum class GradebookFor { kAnybody, kExcel, kExcelComma, kMoodle, kCanvas };

/// UTF-8, RFC 4180; for Excel with a byte order mark.
///   anybody, Excel: id, login, name, points, percent, attempts, trial, state, late_percent,
///                   overridden, answered_at
///   Moodle: Username (the login), Full name and the exercise; Canvas: its own five columns, the
///           exercise, and the line of points possible. Both would clear what a teacher has entered
///           where a field is empty: who has no points has no line.
std::string GradebookText(std::span<const course::GradebookLine> lines,
                          const std::string& exercise,
                          GradebookFor whose);

/// Of CSV, without an exponent.
std::string NumberText(double value);
/// A field of CSV in quotes. A spreadsheet takes what begins like a formula for one: such a text
/// gets an apostrophe, as OWASP recommends.
std::string CsvField(const std::string& text);

}  // namespace faultlab::server
