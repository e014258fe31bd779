#pragma once

#include <boost/json/object.hpp>
#include <string>
#include <vector>

namespace faultlab::tests {

/// A request body made from a correct one by one mistake.
struct BadBody {
  std::string mistake;  ///< "missing /faults/0/component", for the message
  std::string text;
};

/// Every mistake that the schema of a body suggests, one at a time, in every member down to depth
/// three: missing, unknown, each wrong type, too long, too many, out of range, not one of the
/// words; and texts that are not a JSON object.
/// @param document  the OpenAPI description, for $ref
/// @param good      a body that fits the schema
std::vector<BadBody> BadBodies(const boost::json::object& document,
                               const boost::json::value& schema,
                               const boost::json::object& good);

}  // namespace faultlab::tests
