#pragma once

#include <string>

#include "hardware/contact_check.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// What `faultlab rig --self-test` prints.
/// @param contacts  of `--contacts`; null: not checked
std::string TableOf(const SelfTestReport& report, const ContactReport* contacts);
/// {"positions":[{"component","value","line","ok"[,"text"]}],"ok"}, with contacts also
/// "contacts":{"positions":[{"component","value","line","contact","um_expected_v","um_seen_v",
/// "ia_expected_a","ia_seen_a"[,"text"]}],"nominal","ok"}. A reading that is not wired is null.
std::string JsonOf(const SelfTestReport& report, const ContactReport* contacts);

}  // namespace faultlab::hardware
