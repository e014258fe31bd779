#pragma once

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/types/result.h"

namespace faultlab::server {

/// Reads a document that this program wrote: members one by one. The first wrong member is stored
/// as the error; members that are not read are ignored. (Input from people or other programs is
/// read with ObjectReader, which refuses unknown members.)
class DocumentReader {
 public:
  /// @param prefix  precedes the member's name in messages: "quantities/"
  /// @param error   of the whole document; set once
  DocumentReader(const boost::json::object& object,
                 std::string prefix,
                 std::optional<core::Error>& error)
      : object_(object), prefix_(std::move(prefix)), error_(error) {}

  /// Finite and at least `least`.
  double Number(std::string_view member, double least);
  /// null and absent give nothing.
  std::optional<double> NumberOrNull(std::string_view member);
  std::string Text(std::string_view member);
  bool Flag(std::string_view member);
  const boost::json::object& Object(std::string_view member);
  const boost::json::array& Array(std::string_view member);

  void Refuse(std::string_view member, const std::string& message);

 private:
  const boost::json::object& object_;
  std::string prefix_;
  std::optional<core::Error>& error_;
};

/// An entry of an array of objects; if it is not an object, an empty one, so that its first member
/// is refused.
const boost::json::object& EntryOf(const boost::json::value& value);

}  // namespace faultlab::server
