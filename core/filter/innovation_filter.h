#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/filter/innovations.h"

namespace faultlab::core {

/// Runs the Kalman filter of `model` over a stretch from an unknown state, that is, the initial
/// state is projected out; only the slow friction torque starts from its stationary prior.
///   -2 log p(stretch) = chi2 + log_det + const
/// Readings of one sample are used one after the other, so the innovations are white across
/// channels too. Once the gains have settled they are held constant. A clipped um counts only if
/// the prediction lies inside the rail. `trace`, when given, is resized.
/// No answer: a stretch without readings has count 0; a model that is not finite gives a chi2 that
/// is not finite.
/// Source: R. E. Kalman, J. Basic Eng. 82 (1960); the likelihood of the innovations: F. C.
/// Schweppe, IEEE Trans. Inf. Theory 11 (1965); scalar readings in turn: G. J. Bierman (1977),
/// chapter 2. Cost 25-60 ns per sample.
InnovationSummary RunInnovations(const PredictionModel& model,
                                 std::span<const Observation> stretch,
                                 InnovationTrace* trace = nullptr);

/// The same with a model that changes during the stretch (a fault begins, a parameter drifts); the
/// state is carried over.
/// Contract: segments not empty, the first from sample 0, rising.
InnovationSummary RunInnovations(ModelPath path,
                                 std::span<const Observation> stretch,
                                 InnovationTrace* trace = nullptr);

/// The same for many paths. sums[i] and column i of `table` have the same bits as a run of path i
/// alone. `table`, when given, is resized; columns beyond the paths are padding. A single filter is
/// one chain of dependent operations; several filters side by side, two or four to a register, hide
/// that latency: 8-13 ns per sample and path, 20 ns in the first 100 samples while the covariance
/// changes (with AVX2; half as much again without).
/// Contract: as many sums as paths, at least one.
void RunInnovations(std::span<const ModelPath> paths,
                    std::span<const Observation> stretch,
                    std::span<InnovationSummary> sums,
                    InnovationTable* table = nullptr);
/// The same, and fills mc_cross and mc_square.
void RunWithMcResponse(std::span<const ModelPath> paths,
                       std::span<const Observation> stretch,
                       std::span<InnovationSummary> sums);

/// |whitened innovation| of one channel's readings, smallest first.
std::vector<double> SortedMagnitudes(const InnovationTrace& trace,
                                     std::span<const Observation> stretch,
                                     std::size_t channel);
/// Their standard deviation as their median tells it, which impulses do not move: of normal values.
/// Contract: not empty.
double RobustSigma(std::span<const double> sorted_magnitudes);

}  // namespace faultlab::core
