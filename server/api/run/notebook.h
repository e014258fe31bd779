#pragma once

#include <string>
#include <string_view>

namespace faultlab::server {

/// A notebook (nbformat 4.5) with a recording in it, which Jupyter runs with Python alone; its
/// figure needs matplotlib.
/// @param csv  as FormatCsv writes it
std::string NotebookText(std::string_view title, std::string_view csv);

}  // namespace faultlab::server
