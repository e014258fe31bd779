#pragma once

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/lab/lab_types.h"

namespace faultlab::server::lab {

/// How long before its end the user of a session is warned.
inline constexpr std::array kWarnings = {
    Milliseconds{300'000}, Milliseconds{60'000}, Milliseconds{30'000}};
/// How many of the warnings are due when this is left.
int WarningStage(Milliseconds left);

/// "5 minutes left", "90 s left".
std::string LeftText(Milliseconds left);
/// @param reason  of a Notice
/// @param why  what a person or the rig said of it; may be empty
/// @returns English, for programs; the page makes its own sentence of the reason
std::string ReasonText(std::string_view reason, const std::string& why);

/// One booking as a line of Outage::fallen.
std::string WriteFallen(const Booking& booking);
std::vector<std::pair<UserId, Interval>> ReadFallen(const Outage& outage);

}  // namespace faultlab::server::lab
