#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/paper/reproduction/reproduction.h"
#include "core/types/result.h"
#include "server/plots/figure.h"

namespace faultlab::server {

struct PaperFigure {
  int number = 0;
  Figure figure;
};

/// The paper's Figures 4, 6, 14-21 and 23, of records simulated with `seed`. The fits in the legend
/// of Figure 23 are those of Table 14 in `reproduction`.
core::Result<std::vector<PaperFigure>> MakePaperFigures(const core::Bench& bench,
                                                        std::uint64_t seed,
                                                        const core::Reproduction& reproduction);

/// As figure_14.png .. figure_23.png in `folder`, which is made when missing.
core::Status DrawPaperFigures(const std::vector<PaperFigure>& figures, const std::string& folder);

}  // namespace faultlab::server
