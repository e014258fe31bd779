#pragma once

#include <cstdint>
#include <string>

#include "core/bench/bench.h"
#include "core/types/result.h"

namespace faultlab::server {

/// Draws the paper's Figures 14-20 and 23 from simulated records into `folder` (made when missing)
/// as figure_14.png .. figure_23.png.
core::Status DrawPaperPictures(const core::Bench& bench,
                               const std::string& folder,
                               std::uint64_t seed);

}  // namespace faultlab::server
