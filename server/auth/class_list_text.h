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

/// What a list was taken for.
struct ClassListText {
  std::vector<ClassListLine> lines;
  std::string login_from;  ///< title of the column of logins; empty: the list has no titles
  std::string name_from;   ///< of names, "Vorname + Nachname" where it is two
};

/// A class list as spreadsheets and other programs write it. Fields are parted by a comma, a
/// semicolon or a tab, whichever comes first, or by what a first line "sep=;" says; fields in
/// quotes may contain it (RFC 4180). A first line is of titles if it names a column of logins,
/// index numbers or addresses of mail (they are logins, in that order) and one of names, or of
/// first and last names, in English, German, Spanish, French or Serbian; or if it alone has no
/// digit and no @ where all logins below have one. Without titles a line is login and name. An
/// index number such as "RA 301/2026" is the login ra-301-2026. Lines without a word are left out;
/// a login that stands twice under one name counts once. Refuses by line: "line_without_name",
/// "line_login_wrong", "line_name_length", "line_login_twice".
core::Result<ClassListText> ParseClassList(std::string_view utf8);

}  // namespace faultlab::server
