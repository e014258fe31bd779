#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"

namespace faultlab::server {

struct ClassListLine {
  std::string login;  ///< NormalLogin
  std::string name;   ///< CleanName
};

/// A class list as spreadsheets write it. Fields are parted by a comma, a semicolon or a tab,
/// whichever comes first, or by what a first line "sep=;" says; fields in quotes may contain it
/// (RFC 4180). With a first line that names a column "login" and one "name", in any order, others
/// are left out; without it a line is login and name. A login that stands twice under one name
/// counts once. Refuses by line: "line_without_name", "line_login_wrong", "line_name_length",
/// "line_login_twice".
core::Result<std::vector<ClassListLine>> ParseClassList(std::string_view utf8);

}  // namespace faultlab::server
