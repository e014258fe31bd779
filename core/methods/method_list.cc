#include "core/methods/method_list.h"

#include <algorithm>
#include <array>

#include "core/methods/method_tunings.h"
#include "core/methods/neural_network.h"

namespace faultlab::core {
namespace {

constexpr std::array kBlock = {100.0, 200.0, 400.0};
constexpr std::array kForgetting = {0.95, 0.97, 0.98, 0.99};
constexpr std::array kLogSd = {0.5, 1.0, 2.0};
constexpr std::array kDerivativeWindow = {4.0, 8.0, 16.0};
constexpr std::array kParityWindow = {25.0, 50.0, 100.0};
constexpr std::array kPoles = {0.95, 0.85, 0.7};
constexpr std::array kNoiseFactor = {0.5, 1.0, 2.0};
constexpr std::array kBand = {2.0, 3.0, 5.0};
constexpr std::array kSignalWindow = {64.0, 128.0, 256.0};
constexpr std::array kEvaluations = {100.0, 200.0, 400.0};
constexpr std::array kSmoothed = {3.0, 10.0, 20.0};
constexpr std::array kSwaWindow = {50.0, 100.0, 200.0};
constexpr std::array kSiaWindow = {20.0, 100.0, 500.0};
constexpr std::array kNothing = {0.0};

constexpr std::string_view kEstimation = "parameter estimation";
constexpr std::string_view kModel = "model";
constexpr std::string_view kSearch = "optimisation";

constexpr std::string_view kSearchPaper =
    "offline; good for tuning and selection; high cost; detection only, not in real time";

MethodInfo Info(std::string_view name,
                std::string_view title,
                std::string_view group,
                std::string_view tuned,
                std::span<const double> tunings,
                std::unique_ptr<Method> (*make)(const MethodTask&),
                std::string_view paper) {
  MethodInfo info;
  info.name = name;
  info.title = title;
  info.group = group;
  info.tuned = tuned;
  info.tunings = tunings;
  info.make = make;
  info.paper = paper;
  const auto chosen = std::find_if(kMethodTunings.begin(),
                                   kMethodTunings.end(),
                                   [&](const MethodTuning& tuning) { return tuning.name == name; });
  info.tuning = chosen != kMethodTunings.end() ? chosen->tuning : tunings.front();
  info.level = chosen != kMethodTunings.end() ? chosen->level : 0.5;
  const bool own = chosen != kMethodTunings.end() && chosen->level_all > 0.0;
  info.level_all = own ? chosen->level_all : info.level;
  return info;
}

std::vector<MethodInfo> MakeList() {
  std::vector<MethodInfo> all = {
      Info("ls",
           "Least squares, batch",
           kEstimation,
           "block, samples",
           kBlock,
           &MakeBatchLeastSquares,
           "offline; for constant faults; low cost; disturbed by noise and transients; detection "
           "only"),
      Info("rls",
           "RLS with forgetting",
           kEstimation,
           "lambda",
           kForgetting,
           &MakeForgettingLeastSquares,
           "real time; for gradual changes; moderate cost; disturbed by noise and abrupt faults; "
           "detection and identification"),
      Info("rls-reset",
           "RLS, reset by variance",
           kEstimation,
           "lambda",
           kForgetting,
           &MakeResettingLeastSquares,
           ""),
      Info("ekf-bank",
           "EKF, bank of one parameter",
           kEstimation,
           "sd of log value",
           kLogSd,
           &MakeEkfBank,
           "real time if tuned; for nonlinear plants; high cost; needs an accurate model and noise "
           "covariances; detection, isolation and identification"),
      Info("ekf-joint",
           "EKF, all parameters",
           kEstimation,
           "sd of log value",
           kLogSd,
           &MakeEkfJoint,
           ""),
      Info("ukf-bank",
           "UKF, bank of one parameter",
           kEstimation,
           "sd of log value",
           kLogSd,
           &MakeUkfBank,
           "real time if tuned; very accurate; very high cost; hard to tune; detection, isolation "
           "and identification"),
      Info("ukf-joint",
           "UKF, all parameters",
           kEstimation,
           "sd of log value",
           kLogSd,
           &MakeUkfJoint,
           ""),
      Info("agt",
           "Algebraic derivatives",
           kEstimation,
           "window, samples",
           kDerivativeWindow,
           &MakeAlgebraicDerivatives,
           "offline; accurate on paper; high cost; symbolic derivation, not robust to noise; "
           "detection, isolation and identification"),
      Info("ga",
           "Genetic algorithm",
           kSearch,
           "evaluations a component",
           kEvaluations,
           &MakeGeneticSearch,
           kSearchPaper),
      Info("pso",
           "Particle swarm",
           kSearch,
           "evaluations a component",
           kEvaluations,
           &MakeParticleSearch,
           kSearchPaper),
      Info("woa",
           "Whale optimisation",
           kSearch,
           "evaluations a component",
           kEvaluations,
           &MakeWhaleSearch,
           ""),
      Info(
          "nn",
          "Neural network",
          "data",
          "windows averaged",
          kSmoothed,
          &MakeNeuralNetwork,
          "real time for inference; accurate with complex patterns; costly training; complete only "
          "with rules added"),
      Info("fuzzy",
           "Fuzzy rules on b0, b1, a1",
           "data",
           "SIA window K",
           kSiaWindow,
           &MakeFuzzyRules,
           ""),
      Info("parity",
           "Parity equations",
           kModel,
           "window, samples",
           kParityWindow,
           &MakeParityEquations,
           ""),
      Info("luenberger",
           "Luenberger observers, bank",
           kModel,
           "poles, share of the model's",
           kPoles,
           &MakeLuenbergerBank,
           ""),
      Info("kalman",
           "Kalman filters, bank",
           kModel,
           "noise, share of calibrated",
           kNoiseFactor,
           &MakeKalmanBank,
           ""),
      Info("sliding",
           "Sliding-mode observers, bank",
           kModel,
           "band, standard deviations",
           kBand,
           &MakeSlidingModeBank,
           ""),
      Info("signal",
           "Spectra and wavelet energy",
           "signal",
           "window, samples",
           kSignalWindow,
           &MakeSignalBased,
           ""),
      Info("swa",
           "SWA + selected Jacobian",
           "paper",
           "window K",
           kSwaWindow,
           &MakePaperSwa,
           "real time; robust to noise; for abrupt faults; low cost; depends on the window; "
           "detection, isolation and identification"),
      Info("sia",
           "SIA + decision algorithm",
           "paper",
           "data length K",
           kSiaWindow,
           &MakePaperSia,
           "real time; robust to noise; clear link to the parts; moderate cost; depends on both "
           "lengths; detection, isolation and identification"),
      Info("faultlab", "faultlab", "faultlab", "nothing", kNothing, &MakeFaultlab, ""),
  };
  for (MethodInfo& info : all) {
    if (info.name == "ls" || info.name == "signal") info.pace = MethodPace::kBlocks;
    if (info.group == kSearch) info.pace = MethodPace::kAfterwards;
    if (info.name == "parity") info.identifies = false;
    if (info.name == "faultlab") info.level = info.level_all = 0.5;  // it has its own levels
  }
  return all;
}

}  // namespace

std::span<const MethodInfo> AllMethods() {
  static const std::vector<MethodInfo> kAll = MakeList();
  return kAll;
}

const MethodInfo* FindMethod(std::string_view name) {
  for (const MethodInfo& info : AllMethods()) {
    if (info.name == name) return &info;
  }
  return nullptr;
}

bool Fits(const MethodInfo& method, const Bench& bench) {
  return method.name != "nn" || TrainedNetwork().bench == bench.name;
}

}  // namespace faultlab::core
