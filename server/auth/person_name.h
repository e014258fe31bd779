#pragma once

#include <string>
#include <string_view>

namespace faultlab::server {

/// A person's name as it may stand in lists, mails and spreadsheets: without control characters and
/// marks of invisible width or writing direction, without blanks around it, and without the
/// characters by which a spreadsheet takes a cell for a formula. Empty when nothing is left.
/// `utf8` is valid.
std::string CleanName(std::string_view utf8);

}  // namespace faultlab::server
