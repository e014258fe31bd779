#pragma once

#include <vector>

namespace faultlab::testing {

/// Least squares of one window by QR and SVD, independent of the code under test.
struct BatchAnswer {
  std::vector<double> theta;
  std::vector<double> sigma;
  std::vector<double> scale;  ///< |y| / |phi_j|: the size of theta_j that would explain all of y
  double sse = 0.0;
  double sum_of_squares = 0.0;  ///< of y
  double unit_condition = 0.0;  ///< 2-norm, of the normal matrix scaled to unit diagonal
};

/// @param rows  each phi_1 .. phi_P, y
BatchAnswer SolveBatch(const std::vector<std::vector<double>>& rows);

}  // namespace faultlab::testing
