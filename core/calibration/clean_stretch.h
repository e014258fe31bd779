#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/calibration/stretch_fit.h"
#include "core/filter/map_fit.h"
#include "core/filter/observation.h"
#include "core/types/calibration.h"
#include "core/types/hum.h"

namespace faultlab::core {

struct Readings {
  std::vector<Observation> observations;
  std::vector<double> t_s;  ///< run times of them
};

/// The readings that a calibration with these options is of.
Readings ReadingsOf(std::span<const Sample> samples, const CalibrationOptions& options);

/// A healthy stretch rid of what the mains and its wires add, and the rig that explains the rest.
///
///   samples --> hum taken out --> readings that stand alone left out --> explained()
///                  ^-- once more, if such readings may have hidden it --'
class CleanStretch {
 public:
  /// Explains the stretch as it is read.
  /// @param samples, options  outlive this object
  /// @param mask  bit c: there are readings of channel c
  /// @param expected_delta_s  as ExplainStretch
  CleanStretch(std::span<const Sample> samples,
               const CalibrationOptions& options,
               unsigned mask,
               const RigParameters& data_sheet,
               GaussianPrior prior,
               std::optional<double> expected_delta_s);
  CleanStretch(const CleanStretch&) = delete;
  CleanStretch& operator=(const CleanStretch&) = delete;

  void TakeOut();
  /// Writes what was taken out into `calibration`, and a sentence of it into its checks.
  void Tell(Calibration& calibration) const;

  /// Its samples belong to this object.
  const HealthyStretch& stretch() const { return stretch_; }
  const Explained& explained() const { return explained_; }
  /// The readings without the hum, and with those that stand alone.
  const std::vector<Observation>& with_impulses() const { return with_impulses_; }

 private:
  void Explain();
  PredictionModel Model() const;
  void TakeOutHum();
  void LeaveOutImpulses();

  const std::span<const Sample> samples_;
  const CalibrationOptions& options_;
  const RigParameters data_sheet_;
  const GaussianPrior prior_;
  const std::optional<double> expected_delta_s_;
  Readings readings_;
  std::vector<Observation> with_impulses_;
  HealthyStretch stretch_;
  Explained explained_;
  Hum hum_;
  std::size_t impulses_ = 0;
};

}  // namespace faultlab::core
