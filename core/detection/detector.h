#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/bench/bench.h"
#include "core/detection/noise_scale.h"
#include "core/filter/impulses.h"
#include "core/filter/prediction_model.h"
#include "core/filter/riccati_recursion.h"
#include "core/types/calibration.h"

namespace faultlab::core {

/// An alarm of the detection bank.
struct Alarm {
  const char* detector = "";  ///< "residual", "cusum", "glr_25", "glr_100", "glr_500"
  double statistic = 0.0;
  double threshold = 0.0;
  int samples_ago = 0;  ///< estimated onset, before the alarm's sample
  bool sharp = false;   ///< the sample that raises the alarm is far off, so it is certainly faulty
};

/// The detection bank around one reference model (nominal, or nominal with known faults).
///   z: whitened innovations of the reference's settled Kalman filter, um then ia then w; white,
///      unit variance; the slow noise of friction is part of the model
///   residual  |z|, the largest over the channels
///   CUSUM     g <- max(0, g + sum over channels of (3/8 z^2 - ln 2)): variance 4 against 1
///   GLR       max over directions j of (sum s_j z)^2 / (sum s_j^2), over the newest 25 and 100
///             samples (0.25 s and 1 s above 100 Hz), and with forgetting over 500 samples (5 s)
///             for what is small and stays
///   s_j: response of z to a change of one component: the difference between the filter of the
///        changed model and the filter of the reference, which run side by side
/// A reference that was estimated from n samples is itself uncertain: GLR levels rise by 1 + W/n. z
/// is scaled to the noise of the healthy record (noise_scale.h).
/// No answer: a sample without readings, or with um at a rail that the prediction lies beyond, adds
/// nothing to any statistic. After a gap the CUSUM begins at zero; the GLRs keep what they have,
/// and go on when the state has been found again.
/// Cost: about 0.3 us a sample with all channels, a third more where the rig walks; no allocation
/// after construction. Source: CUSUM: E. S. Page, Biometrika 41 (1954); GLR: A. S. Willsky, H. L.
/// Jones, IEEE Trans. Autom. Control 21 (1976); both: M. Basseville, I. V. Nikiforov, Detection of
/// Abrupt Changes (1993), sections 2.2, 2.4 and 7.2.
class Detector {
 public:
  /// @param bench  the bench whose components give the directions
  /// @param mask  channels in use
  /// @param reference_samples  number of samples from which the reference was estimated
  /// @param noise_scale  what is known of the noise; this detector continues the estimate
  /// @param speed_step_s  BenchChannel::step_s where the reference has a fault: its motor may turn
  ///        faster than the one whose noise was calibrated, and its speed is rounded more coarsely
  /// @param impulses  single readings are far off at times (Calibration::impulse_share): one of
  ///        them corrects no state and raises no alarm, about four in a row do
  /// @param error  what the model leaves of a healthy motor: a change that its walk explains
  ///        raises no alarm, and each direction has its own level (Observation::trust is the rest):
  ///        GLR = (sum s_j z)^2 / (sum s_j^2 + sum over w of (sum s_j s_w)^2), s_w the responses
  ///        to each of ModelError::walk
  Detector(const Bench& bench,
           const RigParameters& reference,
           const NoiseLevel& noise,
           double period_s,
           unsigned mask,
           const DetectionThresholds& thresholds,
           int reference_samples,
           const NoiseScale& noise_scale,
           double speed_step_s = 0.0,
           bool impulses = false,
           const ModelError& error = {});

  std::optional<Alarm> Push(const Observation& observation);
  Detector(const Detector&) = delete;
  Detector& operator=(const Detector&) = delete;

  /// The five statistics of the newest sample, divided by the inflation of their thresholds.
  struct Statistics {
    double residual = 0.0;
    double cusum = 0.0;
    double glr_short = 0.0;
    double glr_long = 0.0;
    double glr_slow = 0.0;
  };
  const Statistics& statistics() const { return statistics_; }
  /// The GLRs of the three windows by direction; the largest of each are statistics().
  using Directions = std::array<std::array<double, ModelError::kDirections>, 3>;
  const Directions& directions() const { return directions_; }
  /// Reading minus prediction of um (V), ia (A) and w (rad/s) in the newest sample, bounded to four
  /// standard deviations of a settled filter; 0 where nothing was read.
  std::array<double, kOutputCount> BoundedInnovations() const;
  /// Whitened by the noise of the calibration; 0 where nothing was read.
  const std::array<double, kOutputCount>& whitened() const { return whitened_; }
  const NoiseScale& noise_scale() const { return noise_scale_; }

  static constexpr int kDirections = ModelError::kDirections;
  /// Samples of the windows at 100 Hz; faster records have more samples in them (SpanOf).
  static constexpr int kShort = 25;
  static constexpr int kLong = 100;
  static constexpr int kSlow = 500;

 private:
  struct Model {
    PredictionModel model;
    Eigen::Vector4d x = Eigen::Vector4d::Zero();
    FrictionStep friction;  ///< of the last step
  };
  static constexpr std::size_t kWalking = kWarmingParts.size();
  /// Of one sample, or summed over a window: by direction.
  template <class Number>
  struct Products {
    std::array<Number, kDirections> cross{};   ///< s_j z
    std::array<Number, kDirections> square{};  ///< s_j^2
    /// s_j s_w, of what walks.
    std::array<std::array<Number, kDirections>, kWalking> with_walk{};
  };
  using Cell = Products<float>;
  /// Where a rig that walks is by now, in standard deviations of its walk, as the newest seconds
  /// tell it: what |z| and CUSUM take out.
  struct Walked {
    Eigen::Matrix3d square = Eigen::Matrix3d::Identity();  ///< of s_w, and of the prior
    Eigen::Vector3d cross = Eigen::Vector3d::Zero();       ///< of s_w z
    Eigen::Vector3d at = Eigen::Vector3d::Zero();
  };

  void Restart(const Observation& observation);
  bool walks() const { return models_used_ > kWalkModels; }
  /// Adds the newest sample to the sum of a window, which `leaving` leaves.
  void Slide(const Cell& newest, const Cell& leaving, Products<double>& sum) const;
  void Forget(const Cell& newest, Products<double>& sum) const;
  double Glr(const Products<double>& sum, std::size_t direction) const;
  const ChannelGains& Gains(unsigned use, double passage_variance);
  /// What a passage of the reference's motor through rest in this period adds to the variance of
  /// its speed ((rad/s)^2); 0 where there is none.
  double PassageVariance(const Observation& observation) const;
  /// `gains` for a speed that is rounded as much as this one is.
  ChannelGains WithRounding(const ChannelGains& gains, double speed_rad_s) const;
  static constexpr std::size_t kWalkModels = kDirections + 1;  ///< the first of them
  /// Innovations of all models; [0] is the reference's.
  using Whitened = std::array<std::array<double, kOutputCount>, kWalkModels + kWalking>;
  void Whiten(const Observation& observation, const ChannelGains& gains, Whitened& z, unsigned use);
  /// The channels whose reading is far from the reference's prediction, wherever a rig that walks
  /// is: it walks less in a sample than an impulse is off.
  unsigned FarOff(const Observation& observation, unsigned use) const;
  int OnsetSamplesAgo() const;

  std::array<Model, kWalkModels + kWalking> models_;
  std::size_t models_used_;  ///< the last three only where the rig walks
  bool limited_ = false;     ///< the supply of some model ends
  double speed_step_s_;
  bool impulses_;
  RowOfOddSamples odd_;
  ChannelGains settled_;
  /// In use while the state is still uncertain after a start or a gap; later `settled_` is used.
  RiccatiRecursion recursion_;
  ChannelGains finding_;
  int lost_ = 0;  // of these, so many are to come
  int finding_samples_ = 0;
  int finding_samples_max_;
  int short_samples_;
  int long_samples_;
  int lost_samples_;     ///< until the state is found again after a gap
  int passage_samples_;  ///< for which gains are found again after a passage through rest
  double forget_;
  DetectionThresholds thresholds_;
  NoiseScale noise_scale_;
  double inflation_short_;
  double inflation_long_;
  double reference_samples_;
  std::array<double, kOutputCount> whitened_{};    ///< of the reference, newest
  std::array<double, kOutputCount> inverse_sd_{};  ///< by which they are
  double cusum_ = 0.0;
  int cusum_age_ = 0;
  Statistics statistics_;
  Directions directions_{};
  std::vector<Cell> ring_;
  int head_ = 0;
  int filled_ = 0;
  Walked walked_;
  Products<double> short_;
  Products<double> long_;
  Products<double> slow_;
  ModelError error_;
  double slow_weight_ = 0.0;         ///< sum of the forgetting factors
  double slow_weight_square_ = 0.0;  ///< sum of their squares
};

}  // namespace faultlab::core
