#pragma once

#include <boost/json/object.hpp>
#include <cstdint>
#include <string>

#include "core/paper/reproduction/reproduction.h"

namespace faultlab::server {

struct ReproduceOptions {
  bool json = false;
  std::string bench;      ///< FILE.toml; empty: the paper's
  std::string plots_dir;  ///< empty: no pictures; made when missing
  std::uint64_t seed = 1;
  int repetitions = 9;  ///< records for each fault, whose median is shown
};

/// The paper's Tables 3-20 beside ours, errata marked; with plots_dir its Figures 4, 6, 14-21
/// and 23.
int RunReproduce(const ReproduceOptions& options);

/// {"tables":[{"table","title","unit","profile","settings","rows":[{"fault":{"component","value"},
/// "name","paper","ours","truth"?,"erratum"?,"compared"}],"mean_relative_error",
/// "mean_difference"}],"fits":[..],"summary":{..}}; RunReproduce adds "figures":[{"number", and
/// what figure_json.h says}].
boost::json::object ToJson(const core::Reproduction& reproduction);

/// The same as tables for a terminal, at most 100 columns wide.
std::string ToText(const core::Reproduction& reproduction);

}  // namespace faultlab::server
