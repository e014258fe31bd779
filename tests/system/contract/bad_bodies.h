#pragma once

#include <boost/json/object.hpp>
#include <string>
#include <vector>

namespace faultlab::tests {

/// One request body made from a good one by one mistake.
struct BadBody {
  std::string mistake;  ///< "missing /faults/0/component", for the message
  std::string text;
};

/// Every mistake that the schema of a body suggests, one at a time, in every member down to depth
/// three: missing, unknown, each wrong type, too long, too many, out of range, no such word; and
/// texts that are no JSON object at all.
/// @param document  the OpenAPI description, for $ref
/// @param good      fits the schema
std::vector<BadBody> BadBodies(const boost::json::object& document,
                               const boost::json::value& schema,
                               const boost::json::object& good);

}  // namespace faultlab::tests
