#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/types/number_text.h"
#include "server/plots/figure_parts.h"

namespace faultlab::server {
namespace {

constexpr int kBins = 60;
constexpr int kBinLeast = 4;  // readings; a mean of fewer is mostly noise
constexpr double kMillinewtonMetres = 1e3;

struct Reading {
  double t_s = 0.0;
  double w_rad_s = 0.0;
  double torque_nm = 0.0;
};

/// KT i - J dw/dt, where the voltage has not changed for a period on either side: between readings
/// the current is then smooth.
std::vector<Reading> ReadingsOf(std::span<const core::Sample> samples,
                                const core::Calibration& rig) {
  const double shaft = core::RadPerSecondOfRpm(rig.nominal.gear_ratio);
  const auto speed = [&](const core::Sample& at) { return (at.n_rpm - rig.n_zero_rpm) * shaft; };
  std::vector<Reading> readings;
  for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
    const core::Sample& before = samples[i - 1];
    const core::Sample& at = samples[i];
    const core::Sample& after = samples[i + 1];
    const bool follows = after.index - before.index == 2;
    if (!follows || before.uc_v != at.uc_v || at.uc_v != after.uc_v) continue;
    const double slope = (speed(after) - speed(before)) / (after.t_s - before.t_s);
    const double torque =
        rig.nominal.kt_nm_per_a * (at.ia_a - rig.ia_zero_a) - rig.nominal.j_kg_m2 * slope;
    if (std::isfinite(torque)) readings.push_back({at.t_s, speed(at), torque});
  }
  return readings;
}

/// Means of equal steps of speed, of the readings within a time.
Series Measured(std::span<const Reading> readings,
                std::pair<double, double> time_s,
                double from_rad_s,
                double to_rad_s) {
  struct Bin {
    double w = 0.0;
    double torque = 0.0;
    int count = 0;
  };
  std::array<Bin, kBins> bins{};
  const double step = (to_rad_s - from_rad_s) / kBins;
  for (const Reading& each : readings) {
    if (each.t_s < time_s.first || each.t_s >= time_s.second) continue;
    const auto place = static_cast<int>((each.w_rad_s - from_rad_s) / step);
    Bin& bin = bins[static_cast<std::size_t>(std::clamp(place, 0, kBins - 1))];
    bin.w += each.w_rad_s;
    bin.torque += each.torque_nm;
    ++bin.count;
  }
  Series series;
  for (const Bin& bin : bins) {
    if (bin.count < kBinLeast) continue;
    series.x.push_back(bin.w / bin.count);
    series.y.push_back(bin.torque / bin.count * kMillinewtonMetres);
  }
  return series;
}

/// Coulomb and viscous friction, Equation (1) without its static part; around rest as the bench has
/// it.
Series Model(const core::Calibration& rig, double b, double from_rad_s, double to_rad_s) {
  Series series;
  const double creep = rig.nominal.range.creep_rad_s;
  constexpr int kPoints = 400;
  for (int i = 0; i <= kPoints; ++i) {
    const double w = from_rad_s + (to_rad_s - from_rad_s) * i / kPoints;
    const double sense = creep > 0.0 ? std::clamp(w / creep, -1.0, 1.0) : (w > 0.0) - (w < 0.0);
    series.x.push_back(w);
    series.y.push_back((rig.mc_nm * sense + b * w) * kMillinewtonMetres);
  }
  return series;
}

/// Equation (1) as the description has it, with B as learnt.
Series Described(const core::FrictionModel& friction,
                 double b,
                 double from_rad_s,
                 double to_rad_s) {
  Series series;
  constexpr int kPoints = 400;
  for (int i = 0; i <= kPoints; ++i) {
    const double w = from_rad_s + (to_rad_s - from_rad_s) * i / kPoints;
    const double sense = (w > 0.0) - (w < 0.0);
    series.x.push_back(w);
    const double torque = friction.mc_nm + friction.StribeckTorque(w);
    series.y.push_back((torque * sense + b * w) * kMillinewtonMetres);
  }
  return series;
}

}  // namespace

Figure MakeFrictionFigure(std::span<const core::Sample> samples,
                          const core::Diagnosis& diagnosis,
                          const FigureContext& context) {
  Figure figure = MakeFigureOf("Friction of the motor", context);
  const core::Calibration& rig = *diagnosis.calibration;
  const std::vector<Reading> readings = ReadingsOf(samples, rig);
  const auto [lowest, highest] =
      std::ranges::minmax_element(readings, {}, [](const Reading& each) { return each.w_rad_s; });
  constexpr double kBeyondRest = 0.1;  // so that the step at rest is seen
  const double top = rig.nominal.range.speed_rad_s;
  const double least = readings.empty() ? -top : lowest->w_rad_s;
  const double most = readings.empty() ? top : highest->w_rad_s;
  const double from = std::min(least, -kBeyondRest * most);
  const double to = std::max(most, -kBeyondRest * least);

  figure.x = {"ω", "rad/s", std::nullopt};
  figure.marks.clear();  // they are instants
  Panel panel;
  panel.y = {"M_{f}", "mN m", std::nullopt};
  const auto add = [&panel](Series series, const std::string& name, Ink ink, Dash dash) {
    series.name = name;
    series.ink = ink;
    series.dash = dash;
    panel.series.push_back(std::move(series));
  };
  constexpr double kForever = std::numeric_limits<double>::infinity();
  const std::vector<double> changes = ChangeTimes(context);
  if (!readings.empty()) {
    const double first_s = changes.empty() ? kForever : changes.front();
    add(Measured(readings, {-kForever, first_s}, from, to),
        changes.empty() ? "measured" : "measured before " + core::Format("%.2f s", first_s),
        Ink::kSky,
        Dash::kSolid);
    if (!changes.empty()) {
      add(Measured(readings, {changes.back(), kForever}, from, to),
          "measured after " + core::Format("%.2f s", changes.back()),
          Ink::kGreen,
          Dash::kSolid);
    }
  }
  const double b = rig.nominal.b_nm_per_rad_s;
  add(Model(rig, b, from, to), "as learnt", Ink::kBlue, Dash::kDashed);
  if (context.friction && context.friction->ms_nm > context.friction->mc_nm) {
    add(Described(*context.friction, b, from, to),
        "simulators, as described",
        Ink::kGrey,
        Dash::kDashed);
  }
  core::PlantParameters faulty = rig.nominal;
  const core::Verdict& verdict = diagnosis.verdict;
  if (verdict.kind == core::VerdictKind::kFault && !verdict.candidates.empty()) {
    faulty.Set(verdict.candidates.front().component, verdict.candidates.front().value);
  }
  if (faulty.b_nm_per_rad_s != b) {
    add(Model(rig, faulty.b_nm_per_rad_s, from, to), "as found", Ink::kVermilion, Dash::kDotted);
  }
  figure.panels.push_back(std::move(panel));
  return figure;
}

}  // namespace faultlab::server
