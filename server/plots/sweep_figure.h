#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/types/component.h"
#include "core/types/estimated_channel.h"
#include "core/types/fault.h"
#include "core/types/result.h"
#include "core/types/sample.h"
#include "server/plots/figures.h"

namespace faultlab::server {

/// What one run of a sweep switched, and what was found of it.
struct SweepRun {
  std::optional<core::Component> component{};  ///< that was switched; absent: a healthy run
  double value = 0.0;                          ///< to which it was switched
  std::vector<core::Component> named{};        ///< that fit: one, or several that look alike
  bool unknown = false;                        ///< a change was seen that no component explains
  std::optional<double> found{};    ///< value of the best candidate; absent: only bounded
  std::optional<double> delay_s{};  ///< from the change to the alarm
};

/// A row for each fault of the sweep, a column for each of `components`, for "unknown" and
/// "nothing", and the mean delay of the alarm and error of the value where the right component is
/// named. The darker a cell, the larger the share of the row's runs; what is named among n
/// components counts 1/n. With more than kSweepRowsMax faults a row is a component.
Figure MakeSweepFigure(std::span<const SweepRun> runs,
                       std::span<const core::Component> components,
                       const std::string& subtitle,
                       const std::string& footer);

inline constexpr std::size_t kSweepRowsMax = 30;

/// One record of a sweep, as it was measured.
struct SweptRecord {
  std::optional<core::Fault> fault;  ///< the first; none: healthy
  std::vector<core::Sample> samples;
  core::EstimatedChannel channel = core::EstimatedChannel::kUm;  ///< that is drawn
};
inline constexpr std::size_t kSweptMax = kOverlayMax;
/// What is shown of a record, about its change.
inline constexpr double kSweptBeforeS = 0.5;
inline constexpr double kSweptAfterS = 4.0;

/// A family of curves: one a value, from shortly before the change on, a panel for each component;
/// healthy records are in each.
/// Refuses records of which nothing is to be drawn. Contract: 1 to kSweptMax records.
core::Result<Figure> MakeSweptFigure(std::vector<SweptRecord> records,
                                     const FigureContext& context);

}  // namespace faultlab::server
