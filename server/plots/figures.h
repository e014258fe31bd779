#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/bench/profile.h"
#include "core/diagnosis/diagnosis.h"
#include "core/types/fault.h"
#include "core/types/frame.h"
#include "core/types/sample.h"
#include "server/plots/figure.h"

namespace faultlab::server {

/// The data that all figures of one recording share.
struct FigureContext {
  std::string name;    ///< "R1 = 100 Ω at 10 s", a run's name or a file's
  std::string footer;  ///< rig, run id, version
  /// What changed on the rig, if it may be shown, in time order; a nominal value is a return.
  std::vector<core::Fault> faults;
  std::vector<core::FaultEpisode> episodes;  ///< what was found
  /// Horizontal reference lines of the estimates, {b0d, b1d, a1d} and {b0, b1, a1}; from the
  /// calibration of the rig, or from the paper's nominal values.
  std::optional<std::array<double, 3>> nominal_swa;
  std::optional<std::array<double, 3>> nominal_sia;
  /// Corners of the speed that the rig was to have, in the unit of n; empty without speed control.
  std::vector<double> reference_t_s{};
  std::vector<double> reference_n_rpm{};
  /// As the description has it; drawn where static friction is above Coulomb's.
  std::optional<core::FrictionModel> friction{};
  core::EstimatedChannel estimated = core::EstimatedChannel::kUm;  ///< of which the estimates are
};

/// Paper Figures 14-16: Uc with a magnified part, Um, and Ia and n where the recording has them.
Figure MakeSignalsFigure(std::span<const core::Sample> samples, const FigureContext& context);

enum class EstimatorFamily { kSwa, kSia };

/// Paper Figures 17-20: b0, b1 and a1, a panel each; the three windows of the family, which differ
/// in colour and in dash; nominal lines, markers, and the transient after the fault ((K-1)T or
/// (K+m-1)T) shaded. An estimate that is invalid, not excited or older than its sample is a gap in
/// the line.
Figure MakeEstimatesFigure(std::span<const core::Frame> frames,
                           EstimatorFamily family,
                           const FigureContext& context);

/// The estimates of one window over a record; a value that cannot be drawn is NaN.
struct EstimateCurve {
  std::string name;  ///< "K = 100", "(K, m) = (100, 20)"
  std::vector<double> t_s;
  std::array<std::vector<double>, 3> theta;  ///< b0d b1d a1d, or b0 b1 a1
  int settling_samples = 0;                  ///< after a change: (K-1), SIA (K+m-1)
};
/// The curve of one estimator, frame by frame: begin with an empty one.
EstimateCurve EmptyCurve(core::EstimatorId estimator);
void Append(const core::Frame& frame, core::EstimatorId estimator, EstimateCurve& curve);
EstimatorFamily FamilyOf(core::EstimatorId estimator);
/// By the length of their windows.
std::array<core::EstimatorId, 3> EstimatorsOf(EstimatorFamily family);
/// The number of pairs of ink and dash for curves.
inline constexpr std::size_t kEstimateCurvesMax = 6;

/// The same figure for any windows of one family, at most kEstimateCurvesMax. Throws ContractError
/// for more.
Figure MakeCurvesFigure(std::vector<EstimateCurve> curves,
                        EstimatorFamily family,
                        const FigureContext& context);

/// "K = 100", "(K, m) = (100, 20)".
std::string WindowName(int window_samples, int integral_samples);

/// Whether an estimate with these standard errors of b0, b1, a1 can be drawn: it is computed from
/// this very sample and its error is known. b1 and a1 come from one pole: if that is only bounded
/// (sigma infinite), neither can be drawn.
bool IsDrawable(core::EstimateStatus status,
                int age_samples,
                const std::array<double, 3>& sigma,
                int parameter);

/// The simulated output of one model, to be compared with the measurement.
struct ModelOutput {
  std::string key;   ///< "swa", "sia", "model_mc_0.33mNm", "faultlab"
  std::string name;  ///< "SWA", "M_{c} 0.33 mNm"
  double fit_percent = 0.0;
  std::vector<double> y;  ///< one value per sample of the stretch
};

struct ModelComparison {
  core::EstimatedChannel channel = core::EstimatedChannel::kUm;  ///< of y: um (V) or ia (A)
  std::vector<double> t_s;                                       ///< the stretch that was simulated
  std::vector<double> y;                                         ///< measured
  std::vector<ModelOutput> models;
};

/// Paper Figure 23: measured Um (or Ia) and the models, the fits in the legend, residuals below.
/// Shows at most `shown_s` seconds from the start of the stretch; the fits are of the whole
/// stretch.
Figure MakeModelsFigure(const ModelComparison& comparison,
                        const FigureContext& context,
                        double shown_s = 2.0);

/// Paper Figures 15-16: the estimated channel of several recordings in one panel.
struct OverlayTrace {
  std::string name;  ///< "R_{1} = 10 Ω"
  std::vector<double> t_s;
  std::vector<double> y;
};
struct OverlayPanel {
  std::string title;  ///< "(a) R_{1}"
  std::vector<OverlayTrace> traces;
  core::EstimatedChannel channel = core::EstimatedChannel::kUm;
};
/// So many traces of a panel can be told apart.
inline constexpr std::size_t kOverlayMax = 15;
Figure MakeOverlayFigure(const std::vector<OverlayPanel>& panels, const FigureContext& context);

/// Paper Figure 4: friction torque over the speed of the motor's shaft, measured (KT i - J dw/dt,
/// where the record has ia and n) and of the model. Contract: the diagnosis has a calibration.
Figure MakeFrictionFigure(std::span<const core::Sample> samples,
                          const core::Diagnosis& diagnosis,
                          const FigureContext& context);

/// Paper Figure 6: the main steps from a healthy rig to a fault's value, and how far the newest
/// verdict with a path went. Contract: HasDecisions of its bench.
Figure MakeStepsFigure(const core::Diagnosis& diagnosis, const FigureContext& context);

/// Paper Figure 21: the decision algorithm, and the way that the newest verdict with a path took
/// through it. Contract: HasDecisions(bench).
Figure MakeDecisionsFigure(const core::Bench& bench,
                           const core::Diagnosis& diagnosis,
                           const FigureContext& context);

/// The names used on the command line and in the HTTP interface.
inline constexpr std::string_view kFigureNames[] = {
    "signals", "swa", "sia", "models", "friction", "steps", "decisions"};
/// The first of them stand in a report.
inline constexpr std::size_t kFiguresOfReport = 4;

}  // namespace faultlab::server
