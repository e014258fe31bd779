#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/methods/method.h"

namespace faultlab::core {

/// When a method can run.
enum class MethodPace {
  kEverySample,  ///< its work of a sample takes less than a period: in real time
  kBlocks,       ///< it answers once per block of samples
  kAfterwards,   ///< it detects at every block; its search runs once, after the alarm
};

/// A row of the paper's Table 21, or a method that the paper names in its introduction.
struct MethodInfo {
  std::string_view name;            ///< "ekf-bank": of options and answers
  std::string_view title;           ///< for people
  std::string_view group;           ///< of the paper's section 1: "parameter estimation", ..
  std::string_view tuned;           ///< what `tuning` is
  std::span<const double> tunings;  ///< that the rule chose from
  double tuning = 0.0;              ///< chosen
  double level = 0.0;               ///< of the statistic: one false alarm a day
  double level_all = 0.0;           ///< the same where it also reads what Channels::kAll adds
  MethodPace pace = MethodPace::kEverySample;
  bool isolates = true;
  bool identifies = true;
  /// What the paper says of it, in other words; empty where Table 21 has no row of it.
  std::string_view paper;
  std::unique_ptr<Method> (*make)(const MethodTask& task) = nullptr;

  double LevelFor(Channels channels) const {
    return channels == Channels::kAll ? level_all : level;
  }
};

/// In the order of Table 21, then those of the introduction, then ours.
std::span<const MethodInfo> AllMethods();
/// nullptr if there is no method of this name.
const MethodInfo* FindMethod(std::string_view name);
/// False for a method that was made for another bench: the neural network.
bool Fits(const MethodInfo& method, const Bench& bench);

/// One for each file of this folder.
std::unique_ptr<Method> MakeBatchLeastSquares(const MethodTask& task);
std::unique_ptr<Method> MakeForgettingLeastSquares(const MethodTask& task);
std::unique_ptr<Method> MakeResettingLeastSquares(const MethodTask& task);
std::unique_ptr<Method> MakeEkfBank(const MethodTask& task);
std::unique_ptr<Method> MakeEkfJoint(const MethodTask& task);
std::unique_ptr<Method> MakeUkfBank(const MethodTask& task);
std::unique_ptr<Method> MakeUkfJoint(const MethodTask& task);
std::unique_ptr<Method> MakeAlgebraicDerivatives(const MethodTask& task);
std::unique_ptr<Method> MakeParityEquations(const MethodTask& task);
std::unique_ptr<Method> MakeLuenbergerBank(const MethodTask& task);
std::unique_ptr<Method> MakeKalmanBank(const MethodTask& task);
std::unique_ptr<Method> MakeSlidingModeBank(const MethodTask& task);
std::unique_ptr<Method> MakeSignalBased(const MethodTask& task);
std::unique_ptr<Method> MakeGeneticSearch(const MethodTask& task);
std::unique_ptr<Method> MakeParticleSearch(const MethodTask& task);
std::unique_ptr<Method> MakeWhaleSearch(const MethodTask& task);
std::unique_ptr<Method> MakeNeuralNetwork(const MethodTask& task);
std::unique_ptr<Method> MakeFuzzyRules(const MethodTask& task);
std::unique_ptr<Method> MakePaperSwa(const MethodTask& task);
std::unique_ptr<Method> MakePaperSia(const MethodTask& task);
std::unique_ptr<Method> MakeFaultlab(const MethodTask& task);

}  // namespace faultlab::core
