#pragma once

#include <string>

#include "server/methods/window_study.h"

namespace faultlab::server {

/// Tables for a person: one line for each window and parameter; where several orders were asked
/// for, also what each leaves.
std::string StudyText(const WindowStudy& study, const std::string& file);

}  // namespace faultlab::server
