#pragma once

#include <boost/json/object.hpp>

#include "server/plots/figure.h"

namespace faultlab::server {

/// The figure for the browser:
/// {"title","subtitle","x":{"label","unit","range"},"panels":[{"title","y",
/// "weight","series":[{"name","ink","dash","stair","x":[],"y":[]}],"levels":[],"bands":[],
/// "inset"}],"marks":[{"kind","x","label"}],"matrix"?,"footer"}. Text is plain; NaN is null. Long
/// series are Thinned().
boost::json::object ToJson(const Figure& figure);

}  // namespace faultlab::server
