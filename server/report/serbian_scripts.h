#pragma once

#include <string>
#include <string_view>

namespace faultlab::server {

/// A Serbian text in Latin script, as Cyrillic, by the page's rules (web/src/i18n/serbian_scripts):
/// {0}, units after numbers, and names of formats and signals stay Latin.
std::string ToCyrillic(std::string_view latin);

}  // namespace faultlab::server
