#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"

namespace faultlab::server {

struct ClassListLine {
  std::string login;  ///< NormalLogin
  std::string name;   ///< CleanName
  std::string mail;   ///< address, where the list has a column of them besides the login
};

/// What a list was taken for.
struct ClassListText {
  std::vector<ClassListLine> lines;
  std::string login_from;  ///< title of the column of logins; empty: the list has no titles
  std::string name_from;   ///< of names, "Vorname + Nachname" where it is two
  std::string mail_from;   ///< of addresses of mail, besides the login
};

/// A class list as spreadsheets and other programs write it. Fields are parted by a comma, a
/// semicolon or a tab, whichever comes first, or by what a first line "sep=;" says; fields in
/// quotes may contain it (RFC 4180), but no line break. A first line without a digit or an @ is of
/// titles if it names logins, index numbers or addresses of mail (the first of them that every line
/// has is the login), or names, or first and last names, in English, German, Spanish, French or
/// Serbian; or if all its words have capitals above logins that all have a digit or an @. Where it
/// names one of the two, the content shows the other. Without titles a line is login and name. An
/// index number such as "RA 301/2026" is the login ra-301-2026. Lines without a word, and Canvas'
/// "Points Possible", are left out; a login that stands twice under one name counts once. Refuses
/// by line: "line_without_name", "line_login_wrong", "line_name_length", "line_login_twice".
core::Result<ClassListText> ParseClassList(std::string_view utf8);

}  // namespace faultlab::server
