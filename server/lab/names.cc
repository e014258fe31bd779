#include <array>
#include <chrono>

#include "core/types/number_text.h"
#include "server/lab/lab_types.h"

namespace faultlab::server::lab {
namespace {

template <typename Enum, std::size_t N>
std::string_view Pick(const std::array<std::string_view, N>& names, Enum value) {
  return names.at(static_cast<std::size_t>(value));
}

}  // namespace

std::string UtcText(WallTime time) {
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(time - day);
  return core::Format("%04d-%02u-%02u %02d:%02d UTC",
                      static_cast<int>(date.year()),
                      static_cast<unsigned>(date.month()),
                      static_cast<unsigned>(date.day()),
                      static_cast<int>(clock.hours().count()),
                      static_cast<int>(clock.minutes().count()));
}

std::string_view Name(RigStatus status) {
  static constexpr std::array<std::string_view, 6> kNames = {
      "offline", "ready", "leased", "cleaning", "quarantined", "maintenance"};
  return Pick(kNames, status);
}

std::string_view Name(TicketState state) {
  static constexpr std::array<std::string_view, 5> kNames = {
      "waiting", "offered", "claimed", "expired", "left"};
  return Pick(kNames, state);
}

std::string_view Name(BookingState state) {
  static constexpr std::array<std::string_view, 8> kNames = {
      "booked", "held", "claimed", "no_show", "cancelled", "unfulfilled", "done", "waiting"};
  return Pick(kNames, state);
}

bool IsLive(const Booking& booking) {
  switch (booking.state) {
    case BookingState::kBooked:
    case BookingState::kHeld:
    case BookingState::kClaimed:
    case BookingState::kWaiting:
      return true;
    case BookingState::kNoShow:
    case BookingState::kCancelled:
    case BookingState::kUnfulfilled:
    case BookingState::kDone:
      return false;
  }
  return false;
}

std::string_view Name(SessionState state) {
  static constexpr std::array<std::string_view, 3> kNames = {"held", "active", "closed"};
  return Pick(kNames, state);
}

std::string_view Name(EndReason reason) {
  static constexpr std::array<std::string_view, 9> kNames = {"",
                                                             "ended",
                                                             "expired",
                                                             "idle",
                                                             "no_show",
                                                             "offer_missed",
                                                             "rig_failed",
                                                             "operator",
                                                             "booking_elsewhere"};
  return Pick(kNames, reason);
}

}  // namespace faultlab::server::lab
