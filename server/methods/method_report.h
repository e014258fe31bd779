#pragma once

#include <boost/json/object.hpp>
#include <string>

#include "server/methods/method_study.h"
#include "server/plots/figure.h"

namespace faultlab::server {

/// The study for a terminal: a line for each method.
std::string ToText(const MethodStudy& study);
/// The title of core/methods.md; behind it come the studies.
std::string MarkdownTitle();
/// One study of core/methods.md: the paper's Table 21 in other words beside our figures.
std::string ToMarkdown(const MethodStudy& study);
boost::json::object ToJson(const MethodStudy& study);
/// Methods by faults, the share of isolated records as colour, the median error as text.
Figure MakeMethodFigure(const MethodStudy& study);

}  // namespace faultlab::server
