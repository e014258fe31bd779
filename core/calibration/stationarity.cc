#include "core/calibration/stationarity.h"

#include <algorithm>
#include <vector>

#include "core/filter/innovation_filter.h"

namespace faultlab::core {
namespace {

constexpr std::size_t kPieces = 6;  // of a quarter
// What acts but for so much as Ra does says nothing besides it.
constexpr double kFreeLeast = 0.02;

struct Sums {
  double cross = 0.0;    ///< of s z
  double square = 0.0;   ///< of s^2
  double with_ra = 0.0;  ///< of s s_Ra

  void Add(double s, double z, double s_ra) {
    cross += s * z;
    square += s * s;
    with_ra += s * s_ra;
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

}  // namespace

bool Stationarity::ra_drifts() const {
  const double whole = ra_change();
  for (std::size_t q = 1; q < ra_shift.size(); ++q) {
    const double step = (ra_shift[q] - ra_shift[q - 1]) / whole;
    if (!(step > 0.03 && step < 0.8)) return false;  // a step is in one of them, or in two
  }
  return true;
}

Stationarity StationarityOf(const RigParameters& rig,
                            const NoiseLevel& noise,
                            double period_s,
                            std::span<const Observation> stretch,
                            std::size_t coordinates) {
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
  const std::vector<double> of_ra = responses(static_cast<std::size_t>(Coordinate::kRa));
  Stationarity found;
  const std::size_t piece = quarter / kPieces + 1;
  const auto piece_of = [&](std::size_t r) { return r / quarter * kPieces + r % quarter / piece; };
  std::array<Sums, kQuarters> ra{};
  std::array<Sums, kQuarters * kPieces> ra_of_piece{};
  for (std::size_t r = 0; r < readings; ++r) {
    ra[r / quarter].Add(of_ra[r], base.whitened[r], 0.0);
    ra_of_piece[piece_of(r)].Add(of_ra[r], base.whitened[r], 0.0);
  }
  for (std::size_t b = 0; b < kQuarters; ++b) {
    if (ra[b].square > 0.0) found.ra_shift[b] = -ra[b].cross / ra[b].square;
  }
  for (std::size_t i = 0; i < coordinates; ++i) {
    const std::vector<double> s = responses(i);
    std::array<Sums, kQuarters> of_quarter{};
    std::array<Sums, kQuarters * kPieces> of_piece{};
    for (std::size_t r = 0; r < readings; ++r) {
      of_quarter[r / quarter].Add(s[r], base.whitened[r], of_ra[r]);
      of_piece[piece_of(r)].Add(s[r], base.whitened[r], of_ra[r]);
    }
    const double scatter = ScatterOf(of_quarter, of_piece);
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
        if (!(ra_of_piece[m].square > 0.0)) continue;
        const double share = of_piece[m].with_ra / ra_of_piece[m].square;
        left -= share * ra_of_piece[m].cross;
        free -= share * of_piece[m].with_ra;
      }
      if (free > kFreeLeast * of.square) {
        found.beyond_ra = std::max(found.beyond_ra, left * left / (free * scatter));
      }
    }
    if (score <= found.score) continue;
    found.score = score;
    found.coordinate = static_cast<int>(i);
    found.shift = shift;
  }
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
