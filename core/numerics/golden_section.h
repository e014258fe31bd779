#pragma once

namespace faultlab::core {

/// Golden section search of a minimum between `a` and `b`, one evaluation a step:
///   x1 = b - r (b - a),   x2 = a + r (b - a),   r = (sqrt 5 - 1)/2,   f1, f2 the costs there
/// The caller evaluates first f1 and f2, then the point that each Narrow() opens. In this way
/// several searches can step side by side. If the cost has one minimum in [a, b], it is found
/// within (b - a) r^steps; of several minima one is found. Where costs differ only by rounding
/// errors, either half may be kept: the value is then exact to about the square root of the
/// rounding error.
/// Source: J. Kiefer, "Sequential minimax search for a maximum", Proc. AMS 4 (1953).
struct GoldenSection {
  static constexpr double kRatio = 0.6180339887498949;

  double a, b, x1, x2;
  double f1 = 0.0;
  double f2 = 0.0;

  GoldenSection(double low, double high)
      : a(low), b(high), x1(high - kRatio * (high - low)), x2(low + kRatio * (high - low)) {}

  bool first_is_better() const { return f1 < f2; }
  double best() const { return first_is_better() ? x1 : x2; }
  double best_cost() const { return first_is_better() ? f1 : f2; }

  /// An interior point whose cost is not yet known.
  struct Open {
    double x;
    double* f;
  };
  /// Keeps the interval around the better point.
  Open Narrow() {
    if (first_is_better()) {
      b = x2;
      x2 = x1;
      f2 = f1;
      x1 = b - kRatio * (b - a);
      return {x1, &f1};
    }
    a = x1;
    x1 = x2;
    f1 = f2;
    x2 = a + kRatio * (b - a);
    return {x2, &f2};
  }
};

/// Narrows [low, high] `steps` times for a cost that is a function of the point.
template <typename Cost>
GoldenSection SearchGoldenSection(double low, double high, int steps, const Cost& cost) {
  GoldenSection section(low, high);
  section.f1 = cost(section.x1);
  section.f2 = cost(section.x2);
  for (int i = 0; i < steps; ++i) {
    const GoldenSection::Open open = section.Narrow();
    *open.f = cost(open.x);
  }
  return section;
}

}  // namespace faultlab::core
