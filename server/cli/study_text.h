#pragma once

#include <boost/json/object.hpp>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/paper/window_study.h"

namespace faultlab::server {

/// The settings of a window study.
struct StudySettings {
  std::string name;
  double period_s = 0.0;
  double from_s = 0.0;
  std::optional<double> change_s;
  std::size_t samples = 0;
};

/// A table for a person: one line for each window and parameter.
std::string StudyText(const std::vector<core::WindowStudyRow>& rows, const StudySettings& settings);

/// {"file","samples","period_s","from_s","change_s","variants":[{"name","method","order","window",
/// "integral","transient_s","settling_s","unexcited_share","parameters":[{"name",
/// "before":{"mean","sd","sigma"},"after"}]}]}
boost::json::object StudyJson(const std::vector<core::WindowStudyRow>& rows,
                              const StudySettings& settings);

}  // namespace faultlab::server
