#pragma once

#include <span>
#include <vector>

#include "server/plots/figures.h"

namespace faultlab::server {

/// Marks of the injected faults and of the diagnosis.
std::vector<Mark> MakeMarks(const FigureContext& context);

/// Time of the first change: the injected one, otherwise the estimated onset; nothing if there is
/// neither.
std::optional<double> FirstChange(const FigureContext& context);

/// Name, time axis, marks and footer, as in every figure of a recording.
Figure MakeFigureOf(const std::string& title, const FigureContext& context);

double MeanPeriod(const core::Sample& first, const core::Sample& last);

/// From the first sample to the end of the last sample's period, so that 20 s end at 20, not 19.99.
std::pair<double, double> WholeTime(const core::Sample& first, const core::Sample& last);

/// t_s and one channel of a recording; a missing sample leaves a NaN so that the line breaks.
Series MakeChannelSeries(std::span<const core::Sample> samples,
                         double core::Sample::*channel,
                         Ink ink);

}  // namespace faultlab::server
