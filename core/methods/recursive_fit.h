#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

#include "core/methods/recursive_least_squares.h"
#include "core/methods/regression.h"

namespace faultlab::core {

struct RecursiveFitOptions {
  double lambda = 1.0;
  /// First samples of the healthy stretch, which settle the recursion; the others measure it.
  std::size_t settle = 0;
  /// Samples that the recursion remembers: the mean over n samples of the stretch scatters too, by
  /// the share memory / n of the covariance, at most by all of it.
  double memory = 0.0;
};

/// Recursive least squares on an equation, measured on the healthy stretch: by how much its
/// coefficients scatter there, and its prediction errors.
class RecursiveFit {
 public:
  /// @param task outlives this; its healthy stretch is fitted here
  /// @param equation makes an equation that has seen nothing
  RecursiveFit(const MethodTask& task,
               const std::function<std::unique_ptr<Equation>()>& equation,
               const RecursiveFitOptions& options);

  /// @returns the error of the prediction; nothing where the sample makes no row
  std::optional<double> Push(const Observation& o);
  /// @returns d' S^-1 d of (b0, b1, a1): their distance from the mean over the healthy stretch
  double Distance() const;
  /// Everything that was seen is doubted: the rows to come decide alone.
  void Doubt();
  MethodFinding Match();

  double error_variance() const { return error_variance_; }  ///< on the healthy stretch
  std::size_t bytes() const { return equation_->bytes(); }   ///< beside its own size

 private:
  Eigen::Vector3d Off() const { return (rls_.theta() - map_.healthy()).head<3>(); }

  const MethodTask& task_;
  std::unique_ptr<Equation> equation_;
  CoefficientMap map_;
  RecursiveLeastSquares rls_;
  Eigen::Vector3d mean_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d healthy_information_ = Eigen::Matrix3d::Identity();
  double error_variance_ = 1.0;
};

}  // namespace faultlab::core
