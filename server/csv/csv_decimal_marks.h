#pragma once

#include <string>
#include <string_view>

namespace faultlab::server {

/// The marks within the numbers of a file. One of two may be of thousands: "0,01" and "1.037" are
/// of one file.
class DecimalMarks {
 public:
  void See(std::string_view cell);

  /// What a refusal says when one of two marks may be of thousands; empty when none is.
  std::string SayTwoMarks() const;

 private:
  /// The first number with each mark, and the first with one that may be of thousands.
  std::string points_, commas_, points_of_thousands_, commas_of_thousands_;
};

}  // namespace faultlab::server
