#pragma once

#include <boost/json/array.hpp>
#include <functional>

namespace faultlab::server {

/// What `each` makes of the items of a range, in their order.
template <typename Range, typename Each = std::identity>
boost::json::array ListOf(Range&& range, Each&& each = {}) {
  boost::json::array list;
  for (auto&& item : range) list.emplace_back(each(item));
  return list;
}

}  // namespace faultlab::server
