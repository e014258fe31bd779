#include "server/plots/isolability_figure.h"

#include <algorithm>
#include <cmath>

#include "core/types/number_text.h"
#include "server/plots/value_text.h"

namespace faultlab::server {
namespace {

/// Distances fade to white over this many decades above the limit.
constexpr double kDecades = 2.0;

double Confusion(double distance, double limit) {
  if (!(distance > limit)) {
    return 1.0;
  }
  return std::clamp(0.75 * (1.0 - std::log10(distance / limit) / kDecades), 0.0, 0.75);
}

std::string DistanceText(double distance) {
  if (!std::isfinite(distance)) {
    return "∞";
  }
  constexpr double kNothing = 0.005;  // smaller values are 0 with two decimals
  constexpr double kLong = 1e4;
  if (distance < kNothing) {
    return "0";
  }
  if (distance < kLong) {
    const int digits = distance < 100.0 ? 2 : 4;
    return core::Format("%.*g", digits, distance);
  }
  const int power = static_cast<int>(std::floor(std::log10(distance)));
  return core::Format("%.1f·10^{%d}", distance / std::pow(10.0, power), power);
}

}  // namespace

Figure MakeIsolabilityFigure(const core::Isolability& isolability, const std::string& subtitle) {
  Figure figure;
  figure.title = "Which faults can be told apart";
  figure.subtitle = subtitle;
  CellMatrix& matrix = figure.matrix;
  matrix.row_title = "Fault";
  matrix.column_title = "Distance (nats) to the nearest record of";
  matrix.columns.push_back("healthy");
  for (const core::SmallestVisible& one : isolability.smallest) {
    matrix.columns.push_back(ComponentLabel(one.component));
  }
  for (const core::FaultIsolability& fault : isolability.faults) {
    const core::Component own = fault.fault.component;
    matrix.rows.push_back(ComponentLabel(own) + " = " +
                          ValueText(fault.fault.value, core::Unit(own)));
    matrix.value.push_back(Confusion(fault.kl_nominal_nats, isolability.kl_visible_nats));
    matrix.text.push_back(DistanceText(fault.kl_nominal_nats));
    for (const core::NearestRival& rival : fault.rival) {
      const double distance = rival.kl_nats;
      const bool itself = rival.component == own;
      matrix.value.push_back(itself ? std::nan("")
                                    : Confusion(distance, isolability.kl_separable_nats));
      matrix.text.push_back(itself ? "" : DistanceText(distance));
    }
  }
  figure.footer = "full colour: cannot be told apart (healthy below " +
                  DistanceText(isolability.kl_visible_nats) + ", another component below " +
                  DistanceText(isolability.kl_separable_nats) + " nats)";
  return figure;
}

}  // namespace faultlab::server
