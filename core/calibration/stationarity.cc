#include "core/calibration/stationarity.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

#include "core/filter/innovation_filter.h"

namespace faultlab::core {
namespace {

constexpr std::size_t kPieces = 6;  // of a quarter
// What acts but for so much as those that walk says nothing besides them.
constexpr double kFreeLeast = 0.02;
constexpr double kRidge = 1e-3;  // keeps solutions regular where nothing acts

constexpr std::size_t kWalking = kWarmingParts.size();
using Gram = Eigen::Matrix<double, kWalking, kWalking>;
using Column = Eigen::Matrix<double, kWalking, 1>;

struct Sums {
  double cross = 0.0;                 ///< of s z
  double square = 0.0;                ///< of s^2
  Column with_walk = Column::Zero();  ///< of s s_w

  void Add(double s, double z, const Column& s_walk) {
    cross += s * z;
    square += s * s;
    with_walk += s * s_walk;
  }
};

/// Of the coordinates that may walk, together.
struct WalkSums {
  Gram gram = Gram::Zero();
  Column cross = Column::Zero();

  void Add(const Column& s, double z) {
    gram += s * s.transpose();
    cross += s * z;
  }
  /// What explains z best, kept near zero by `ridge`.
  Column Shift(const Column& ridge) const {
    return -Gram(gram + Gram(ridge.asDiagonal())).ldlt().solve(cross);
  }
};

/// How much the pieces of a quarter differ from it, in units of noise; at least 1. By the median: a
/// change inside one quarter is no scatter.
template <std::size_t Quarters, std::size_t Pieces>
double ScatterOf(const std::array<Sums, Quarters>& of_quarter,
                 const std::array<Sums, Pieces>& of_piece) {
  constexpr double kMedian = 0.4549;  // of the square of a standard normal variable
  std::vector<double> squares;
  for (std::size_t m = 0; m < Pieces; ++m) {
    const Sums& quarter = of_quarter[m / kPieces];
    const double free = of_piece[m].square * (1.0 - of_piece[m].square / quarter.square);
    if (!(free > 0.0)) continue;
    const double off = of_piece[m].cross - quarter.cross / quarter.square * of_piece[m].square;
    squares.push_back(off * off / free);
  }
  if (squares.empty()) return 1.0;
  const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
  std::nth_element(squares.begin(), middle, squares.end());
  return std::max(1.0, *middle / kMedian);
}

void FindWalk(const std::array<WalkSums, Stationarity::kQuarters>& of_quarter,
              double warming,
              Stationarity& found) {
  constexpr double kStepMin = 0.03;  // of the whole way
  constexpr double kStepMax = 0.8;   // a step is in one of them, or in two
  if (!(warming > 0.0)) return;
  Column ridge;
  for (std::size_t i = 0; i < kWalking; ++i) {
    const double sd = kWarmingParts[i].share * warming;
    ridge(static_cast<Eigen::Index>(i)) = 1.0 / (sd * sd);
  }
  Gram metric = Gram::Zero();
  std::array<Column, Stationarity::kQuarters> shift;
  for (std::size_t q = 0; q < shift.size(); ++q) {
    metric += of_quarter[q].gram;
    shift[q] = of_quarter[q].Shift(ridge);
    for (std::size_t i = 0; i < kWalking; ++i) {
      found.walk_shift[q][i] = shift[q](static_cast<Eigen::Index>(i));
    }
  }
  const Column way = shift.back() - shift.front();
  const double length = way.dot(metric * way);
  for (std::size_t q = 1; q < shift.size(); ++q) {
    const double step = (shift[q] - shift[q - 1]).dot(metric * way) / length;
    if (!(step > kStepMin && step < kStepMax)) return;
  }
  // Each end is known as well as a quarter tells it.
  found.drift = length / (2.0 * Stationarity::kQuarters);
}

}  // namespace

Stationarity::Walk Stationarity::walk() const {
  Walk change{};
  for (std::size_t i = 0; i < change.size(); ++i) {
    change[i] = walk_shift.back()[i] - walk_shift.front()[i];
  }
  return change;
}

Stationarity StationarityOf(const RigParameters& rig,
                            const NoiseLevel& noise,
                            double period_s,
                            std::span<const Observation> stretch,
                            std::size_t coordinates,
                            double warming) {
  constexpr double kSmall = 1e-4;
  constexpr std::size_t kQuarters = Stationarity::kQuarters;
  InnovationTrace base;
  InnovationTrace moved;
  const InnovationSummary whole =
      RunInnovations(MakePredictionModel(rig, noise, period_s), stretch, &base);
  const std::size_t readings = base.whitened.size();
  const std::size_t quarter = (stretch.size() + kQuarters - 1) / kQuarters * kOutputCount;
  const auto responses = [&](std::size_t coordinate) {
    ParameterOffsets q{};
    q[coordinate] = kSmall;
    RunInnovations(
        MakePredictionModel(WithOffsets(rig, q, period_s), noise, period_s), stretch, &moved);
    std::vector<double> s(readings);
    for (std::size_t r = 0; r < readings; ++r) {
      s[r] = (moved.whitened[r] - base.whitened[r]) / kSmall;
    }
    return s;
  };
  std::array<std::vector<double>, kWalking> of_walk;
  for (std::size_t i = 0; i < kWalking; ++i) {
    of_walk[i] = responses(static_cast<std::size_t>(kWarmingParts[i].coordinate));
  }
  const auto walk_at = [&](std::size_t r) {
    return Column(of_walk[0][r], of_walk[1][r], of_walk[2][r]);
  };
  Stationarity found;
  const std::size_t piece = quarter / kPieces + 1;
  const auto piece_of = [&](std::size_t r) { return r / quarter * kPieces + r % quarter / piece; };
  std::array<WalkSums, kQuarters> walk_of_quarter{};
  std::array<WalkSums, kQuarters * kPieces> walk_of_piece{};
  for (std::size_t r = 0; r < readings; ++r) {
    walk_of_quarter[r / quarter].Add(walk_at(r), base.whitened[r]);
    walk_of_piece[piece_of(r)].Add(walk_at(r), base.whitened[r]);
  }
  FindWalk(walk_of_quarter, warming, found);
  double walk_scatter = 1.0;
  for (std::size_t i = 0; i < coordinates; ++i) {
    const std::vector<double> s = responses(i);
    std::array<Sums, kQuarters> of_quarter{};
    std::array<Sums, kQuarters * kPieces> of_piece{};
    for (std::size_t r = 0; r < readings; ++r) {
      of_quarter[r / quarter].Add(s[r], base.whitened[r], walk_at(r));
      of_piece[piece_of(r)].Add(s[r], base.whitened[r], walk_at(r));
    }
    const double scatter = ScatterOf(of_quarter, of_piece);
    const bool walks = std::ranges::any_of(kWarmingParts, [&](const WarmingPart& part) {
      return static_cast<std::size_t>(part.coordinate) == i;
    });
    if (walks) walk_scatter = std::max(walk_scatter, scatter);
    double score = 0.0;
    std::array<double, kQuarters> shift{};
    for (std::size_t b = 0; b < kQuarters; ++b) {
      const Sums& of = of_quarter[b];
      if (!(of.square > 0.0)) continue;
      score = std::max(score, of.cross * of.cross / (of.square * scatter));
      shift[b] = -of.cross / of.square;
      double left = of.cross;
      double free = of.square;
      for (std::size_t m = b * kPieces; m < (b + 1) * kPieces; ++m) {
        const Column share = Gram(walk_of_piece[m].gram + kRidge * Gram::Identity())
                                 .ldlt()
                                 .solve(of_piece[m].with_walk);
        left -= share.dot(walk_of_piece[m].cross);
        free -= share.dot(of_piece[m].with_walk);
      }
      if (free > kFreeLeast * of.square) {
        found.beyond_walk = std::max(found.beyond_walk, left * left / (free * scatter));
      }
    }
    if (score <= found.score) continue;
    found.score = score;
    found.coordinate = static_cast<int>(i);
    found.shift = shift;
  }
  found.drift /= walk_scatter;
  const double average = whole.chi2 / std::max(1, whole.count);
  for (std::size_t b = 0; b < kQuarters; ++b) {
    double chi2 = 0.0;
    const std::size_t begin = std::min(readings, b * quarter);
    const std::size_t end = std::min(readings, begin + quarter);
    for (std::size_t r = begin; r < end; ++r) chi2 += base.whitened[r] * base.whitened[r];
    const double share = static_cast<double>(end - begin) / static_cast<double>(readings);
    if (share > 0.0) found.energy = std::max(found.energy, chi2 / (share * whole.count * average));
  }
  return found;
}

}  // namespace faultlab::core
