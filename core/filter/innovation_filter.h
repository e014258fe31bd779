#pragma once

#include <span>

#include "core/filter/innovations.h"

namespace faultlab::core {

/// Runs the Kalman filter of `model` over a stretch from an unknown state (only the friction's
/// deviation has its stationary prior), that is: the initial state is projected out.
///   -2 log p(stretch) = chi2 + log_det + const
/// Readings of one sample are used one after the other, so the innovations are white across
/// channels too. After the gains have settled they are held. A clipped um counts only if the
/// prediction lies inside the rail. `trace`, when given, is resized.
/// No answer: a stretch without readings has count 0; a model that is not finite has a chi2 that is
/// not.
/// Source: R. E. Kalman, J. Basic Eng. 82 (1960); the likelihood of the innovations: F. C.
/// Schweppe, IEEE Trans. Inf. Theory 11 (1965); scalar readings in turn: G. J. Bierman (1977),
/// chapter 2. Cost 25-60 ns per sample.
InnovationSummary RunInnovations(const PredictionModel& model,
                                 std::span<const Observation> stretch,
                                 InnovationTrace* trace = nullptr);

/// The same with a model that changes on the way (a fault that sets in, a parameter that drifts);
/// the state is carried over.
/// Contract: segments not empty, the first from sample 0, rising.
InnovationSummary RunInnovations(ModelPath path,
                                 std::span<const Observation> stretch,
                                 InnovationTrace* trace = nullptr);

/// The same for many paths: sums[i] and column i of `table` have the bits that path i alone gets.
/// `table`, when given, is resized; columns beyond the paths are padding. A single
/// filter is one chain of dependent operations; several side by side, two or four to a register,
/// hide that latency: 8-13 ns per sample and path, 20 in the first 100 samples, while the
/// covariance moves (AVX2; half as much again without).
/// Contract: as many sums as paths, at least one.
void RunInnovations(std::span<const ModelPath> paths,
                    std::span<const Observation> stretch,
                    std::span<InnovationSummary> sums,
                    InnovationTable* table = nullptr);
/// With mc_cross and mc_square.
void RunWithMcResponse(std::span<const ModelPath> paths,
                       std::span<const Observation> stretch,
                       std::span<InnovationSummary> sums);

}  // namespace faultlab::core
