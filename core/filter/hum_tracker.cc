#include "core/filter/hum_tracker.h"

#include <cmath>
#include <numbers>

namespace faultlab::core {
namespace {

constexpr double kMemoryS = 1.0;

double PhaseOf(const Hum& hum, double t_s) {
  return 2.0 * std::numbers::pi * hum.frequency_hz * t_s;
}

/// Squared ratio of hum to noise.
double Clear(const Hum::Phasor& phasor, double noise) {
  const double ratio = noise > 0.0 ? phasor.amplitude() / noise : 0.0;
  return ratio * ratio;
}

/// Adds `e` at the phase (c, s). @returns by how much that has advanced the phase, rad.
double Correct(Hum::Phasor& phasor, double e, double c, double s) {
  const double square = phasor.cosine * phasor.cosine + phasor.sine * phasor.sine;
  const double turn = square > 0.0 ? e * (c * -phasor.sine + s * phasor.cosine) / square : 0.0;
  phasor.cosine += e * c;
  phasor.sine += e * s;
  return -turn;
}

/// Takes `angle` from the phase.
void Turn(Hum::Phasor& phasor, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  phasor = {c * phasor.cosine - s * phasor.sine, s * phasor.cosine + c * phasor.sine};
}

}  // namespace

Sample WithoutHum(const Sample& sample, const Hum& hum) {
  const double phase = PhaseOf(hum, sample.t_s);
  const double c = std::cos(phase);
  const double s = std::sin(phase);
  Sample clean = sample;
  clean.um_v -= c * hum.um.cosine + s * hum.um.sine;
  clean.ia_a -= c * hum.ia.cosine + s * hum.ia.sine;
  return clean;
}

HumTracker::HumTracker(const Hum& hum, const NoiseLevel& noise, double period_s)
    : hum_(hum), noise_(noise), step_(2.0 * period_s / kMemoryS) {}

void HumTracker::Learn(double t_s, double um_v, double ia_a) {
  if (!hum_.any()) return;
  const double phase = PhaseOf(hum_, t_s);
  const double c = std::cos(phase);
  const double s = std::sin(phase);
  const double um_clear = Clear(hum_.um, noise_.um_v);
  const double ia_clear = Clear(hum_.ia, noise_.ia_a);
  const double um_turn = Correct(hum_.um, step_ * um_v, c, s);
  const double ia_turn = Correct(hum_.ia, step_ * ia_a, c, s);
  if (um_clear + ia_clear <= 0.0) return;
  const double turn = (um_clear * um_turn + ia_clear * ia_turn) / (um_clear + ia_clear);
  const double faster_hz = turn / (4.0 * kMemoryS) / (2.0 * std::numbers::pi);
  hum_.frequency_hz += faster_hz;
  // The phase of this moment stays.
  const double back = 2.0 * std::numbers::pi * faster_hz * t_s;
  Turn(hum_.um, back);
  Turn(hum_.ia, back);
}

}  // namespace faultlab::core
