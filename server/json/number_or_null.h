#pragma once

#include <boost/json/value.hpp>
#include <cmath>
#include <optional>
#include <span>

#include "server/json/list_of.h"

namespace faultlab::server {

/// JSON has neither NaN nor infinity: null stands for both, and for a number that is not there.
inline boost::json::value NumberOrNull(double value) {
  return std::isfinite(value) ? boost::json::value(value) : boost::json::value(nullptr);
}
inline boost::json::value NumberOrNull(const std::optional<double>& value) {
  return value ? NumberOrNull(*value) : boost::json::value(nullptr);
}
inline boost::json::array NumbersOrNull(std::span<const double> values) {
  return ListOf(values, [](double value) { return NumberOrNull(value); });
}

}  // namespace faultlab::server
