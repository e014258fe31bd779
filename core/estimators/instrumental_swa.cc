#include "core/estimators/instrumental_swa.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/estimators/normal_equations.h"
#include "core/types/check.h"
#include "core/types/sample_intake.h"

namespace faultlab::core {
namespace {

constexpr int kP = InstrumentalSwa::kParameters;
constexpr int kOutput = 5;                                 ///< y(k) in the row
constexpr std::array<int, kP> kRegressors = {0, 1, 2, 3};  ///< places in the row
constexpr std::array<int, kP> kInstruments = {0, 1, 4, 3};
/// The simulated output must decay: a pole estimate of larger magnitude is reduced to this one.
constexpr double kPoleMax = 0.995;

using Matrix = std::array<std::array<double, kP>, kP>;
using Vector = std::array<double, kP>;

double Moment(const SlidingMoments<6>& moments, int a, int b) {
  return moments.sums()[PackedIndex(std::max(a, b), std::min(a, b))];
}

/// Gauss-Jordan with partial pivoting. False when a pivot vanishes.
bool Invert(Matrix a, Matrix& inverse) {
  for (std::size_t i = 0; i < kP; ++i) {
    for (std::size_t j = 0; j < kP; ++j) {
      inverse[i][j] = i == j ? 1.0 : 0.0;
    }
  }
  for (std::size_t column = 0; column < kP; ++column) {
    std::size_t best = column;
    for (std::size_t i = column + 1; i < kP; ++i) {
      if (std::abs(a[i][column]) > std::abs(a[best][column])) {
        best = i;
      }
    }
    if (!(std::abs(a[best][column]) > kPivotFloor)) {
      return false;
    }
    std::swap(a[best], a[column]);
    std::swap(inverse[best], inverse[column]);
    const double reciprocal = 1.0 / a[column][column];
    for (std::size_t j = 0; j < kP; ++j) {
      a[column][j] *= reciprocal;
      inverse[column][j] *= reciprocal;
    }
    for (std::size_t i = 0; i < kP; ++i) {
      if (i == column) {
        continue;
      }
      const double factor = a[i][column];
      for (std::size_t j = 0; j < kP; ++j) {
        a[i][j] -= factor * a[column][j];
        inverse[i][j] -= factor * inverse[column][j];
      }
    }
  }
  return true;
}

double FrobeniusNorm(const Matrix& a) {
  double sum = 0.0;
  for (const Vector& row : a) {
    for (double entry : row) {
      sum += entry * entry;
    }
  }
  return std::sqrt(sum);
}

/// sum of (y - phi' theta)^2 over the window, from its moments.
double SquaredErrors(const SlidingMoments<6>& moments, const Vector& theta) {
  double sse = Moment(moments, kOutput, kOutput);
  for (std::size_t i = 0; i < kP; ++i) {
    sse -= 2.0 * theta[i] * Moment(moments, kRegressors[i], kOutput);
    for (std::size_t j = 0; j < kP; ++j) {
      sse += theta[i] * theta[j] * Moment(moments, kRegressors[i], kRegressors[j]);
    }
  }
  return sse > 0.0 ? sse : 0.0;
}

/// The ordinary least-squares solution of the same rows, to start the simulated output.
bool OrdinaryTheta(const SlidingMoments<6>& moments, Vector& theta) {
  constexpr std::array<int, kP + 1> kColumns = {0, 1, 2, 3, kOutput};
  std::array<double, PackedSize(kP + 1)> sums;
  for (int i = 0; i <= kP; ++i) {
    for (int j = 0; j <= i; ++j) {
      sums[PackedIndex(i, j)] = Moment(
          moments, kColumns[static_cast<std::size_t>(i)], kColumns[static_cast<std::size_t>(j)]);
    }
  }
  LeastSquaresSolution<kP> solution;
  SolveNormalEquations<kP>(sums, solution);
  theta = solution.theta;
  return solution.condition < kConditionMax;
}

}  // namespace

InstrumentalSwa::InstrumentalSwa(const Options& options)
    : options_(options), history_(1), moments_(options.window_samples) {
  LAB_CHECK(options.window_samples > kP, options.window_samples);
  estimate_.theta.fill(std::numeric_limits<double>::quiet_NaN());
  estimate_.sigma.fill(std::numeric_limits<double>::quiet_NaN());
}

const Estimate<kP>& InstrumentalSwa::Push(double u_v, double y_v) {
  if (!IsPlausible(u_v) || !IsPlausible(y_v)) {
    moments_.PushEmpty(history_.PushInvalid());
    Remember(past_u_v_, simulated_v_);
    return Update();
  }
  const RowKind kind = history_.PushGood();
  if (kind == RowKind::kValid) {
    moments_.Push({u_v, past_u_v_, -past_y_v_, 1.0, -simulated_v_, y_v});
  } else {
    moments_.PushEmpty(kind);
  }
  if (has_model_) {
    Simulate(u_v);
  } else {
    simulated_v_ = y_v;  // the measured output until there is a model; this gives least squares
  }
  Remember(u_v, y_v);
  return Update();
}

const Estimate<kP>& InstrumentalSwa::PushUnusable() {
  moments_.PushEmpty(history_.PushUnusable());
  Remember(past_u_v_, simulated_v_);
  return Update();
}

void InstrumentalSwa::Skip(int samples) {
  history_.Break();
  if (samples >= moments_.window()) {
    moments_.Clear();
  } else {
    for (int i = 0; i < samples; ++i) {
      moments_.PushEmpty(RowKind::kEmpty);
    }
  }
  constexpr std::int32_t kAgeMax = std::numeric_limits<std::int32_t>::max();
  estimate_.age_samples =
      estimate_.age_samples > kAgeMax - samples ? kAgeMax : estimate_.age_samples + samples;
}

const Estimate<kP>& InstrumentalSwa::Update() {
  const int rows = moments_.rows();
  if (moments_.invalid() != 0 || !moments_.full() || rows <= kP ||
      rows < kFillMin * moments_.window()) {
    estimate_.sse = 0.0;
    estimate_.condition = std::numeric_limits<double>::infinity();
    return Hold(EstimateStatus::kInvalid);
  }
  // Rows and columns are scaled to unit length, so that pivots and condition have no unit.
  Matrix scaled;
  Vector row_scale;
  Vector column_scale;
  for (std::size_t i = 0; i < kP; ++i) {
    row_scale[i] = 1.0 / std::sqrt(Moment(moments_, kInstruments[i], kInstruments[i]));
    column_scale[i] = 1.0 / std::sqrt(Moment(moments_, kRegressors[i], kRegressors[i]));
  }
  for (std::size_t i = 0; i < kP; ++i) {
    for (std::size_t j = 0; j < kP; ++j) {
      scaled[i][j] =
          Moment(moments_, kInstruments[i], kRegressors[j]) * row_scale[i] * column_scale[j];
    }
  }
  Matrix inverse;
  if (!Invert(scaled, inverse)) {
    estimate_.condition = std::numeric_limits<double>::infinity();
    return Hold(EstimateStatus::kNotExcited);
  }
  estimate_.condition = FrobeniusNorm(scaled) * FrobeniusNorm(inverse);
  if (!(estimate_.condition < options_.gate.condition_max)) {
    return Hold(EstimateStatus::kNotExcited);
  }
  Matrix weights;  // (Z' Phi)^-1
  for (std::size_t i = 0; i < kP; ++i) {
    double theta = 0.0;
    for (std::size_t j = 0; j < kP; ++j) {
      weights[i][j] = inverse[i][j] * column_scale[i] * row_scale[j];
      theta += weights[i][j] * Moment(moments_, kInstruments[j], kOutput);
    }
    estimate_.theta[i] = theta;
  }
  estimate_.sse = SquaredErrors(moments_, estimate_.theta);
  const double variance = estimate_.sse / (rows - kP);
  for (std::size_t i = 0; i < kP; ++i) {
    double quadratic = 0.0;
    for (std::size_t a = 0; a < kP; ++a) {
      for (std::size_t b = 0; b < kP; ++b) {
        quadratic +=
            weights[i][a] * weights[i][b] * Moment(moments_, kInstruments[a], kInstruments[b]);
      }
    }
    estimate_.sigma[i] = std::sqrt(variance * quadratic);
  }
  estimate_.age_samples = 0;
  const bool excited = options_.gate.Accepts(estimate_.theta, estimate_.sigma);
  estimate_.status = excited ? EstimateStatus::kExcited : EstimateStatus::kWeak;
  if (excited) {
    model_ = estimate_.theta;
    has_model_ = true;
  } else if (Vector ordinary; OrdinaryTheta(moments_, ordinary)) {
    model_ = ordinary;  // biased, but it stays bounded, unlike instruments that no longer follow y
    has_model_ = true;
  }
  return estimate_;
}

const Estimate<kP>& InstrumentalSwa::Hold(EstimateStatus status) {
  estimate_.sigma.fill(std::numeric_limits<double>::quiet_NaN());
  estimate_.status = status;
  estimate_.age_samples += estimate_.age_samples < std::numeric_limits<std::int32_t>::max();
  return estimate_;
}

void InstrumentalSwa::Simulate(double u_v) {
  const double pole = -model_[2];
  const double kept = std::abs(pole) < kPoleMax ? pole : std::copysign(kPoleMax, pole);
  simulated_v_ = model_[0] * u_v + model_[1] * past_u_v_ + kept * simulated_v_ + model_[3];
}

void InstrumentalSwa::Remember(double u_v, double y_v) {
  past_u_v_ = u_v;
  past_y_v_ = y_v;
}

}  // namespace faultlab::core
