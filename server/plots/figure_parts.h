#pragma once

#include <span>
#include <vector>

#include "server/plots/figures.h"

namespace faultlab::server {

/// Marks of what changed on the rig, and of every detection.
std::vector<Mark> MakeMarks(const FigureContext& context);

/// When something changed, in time order, as far as the rig has reported it.
std::vector<double> ReportedChanges(const FigureContext& context);

/// ReportedChanges(); if there are none, the diagnosis' estimates. For each, the estimators'
/// windows hold samples from before it.
std::vector<double> ChangeTimes(const FigureContext& context);

/// Name, time axis, marks and footer, as in every figure of a recording.
Figure MakeFigureOf(const std::string& title, const FigureContext& context);

double MeanPeriod(const core::Sample& first, const core::Sample& last);

/// From the first sample to the end of the last sample's period, so that 20 s end at 20, not 19.99.
std::pair<double, double> WholeTime(const core::Sample& first, const core::Sample& last);

/// t_s and one channel of a recording; a missing sample leaves a NaN so that the line breaks.
Series MakeChannelSeries(std::span<const core::Sample> samples,
                         double core::Sample::*channel,
                         Ink ink);

inline constexpr double kLensSeconds = 1.0;
/// Magnifies kLensSeconds of the panel's own series above them; not when they are constant.
void AddLens(Panel& panel, double from);

}  // namespace faultlab::server
