#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/methods/method.h"
#include "core/methods/regression.h"

namespace faultlab::core {

inline constexpr int kNetworkInputs = 6;
using NetworkInputs = std::array<double, kNetworkInputs>;

/// Inputs of the network over the newest kNetworkWindow samples: how far b0d, b1d, a1d and the
/// constant of least squares are from the healthy rig, the logarithms of the equation error's and
/// the output's standard deviations over their healthy values; each through asinh.
class NetworkWindow {
 public:
  static constexpr std::size_t kWindow = 80;

  explicit NetworkWindow(const MethodTask& task);
  void Push(const Observation& o);
  void Restart();
  /// Nothing until the window is full.
  std::optional<NetworkInputs> Inputs() const;

 private:
  struct Raw {
    EquationVector theta;
    double log_error = 0.0;
    double log_spread = 0.0;
  };
  Raw RawInputs() const;

  const MethodTask& task_;
  DiscreteEquation equation_;
  std::vector<EquationRow> rows_;
  std::size_t at_ = 0;
  Raw healthy_;
};

/// A perceptron with hidden layers: x <- f(W x + b) for each layer, also the last,
///   f(v) = 1.7159 tanh(v / 3)
/// which is OpenCV's symmetric sigmoid. Outputs: healthy, then one for each name, then the
/// logarithm of value / start over kNetworkLogScale.
struct Network {
  std::string_view bench;           ///< name of the bench whose runs it learned; empty: no network
  std::string_view recipe;          ///< how it was made
  std::span<const int> components;  ///< places in the list of the bench
  std::span<const int> layers;      ///< sizes, inputs first
  std::span<const float> weights;   ///< of each layer, by output: the bias, then the inputs
};

inline constexpr double kNetworkLogScale = 5.0;

/// The network that is versioned beside this file.
const Network& TrainedNetwork();
std::vector<double> Evaluate(const Network& network, std::span<const double> inputs);

}  // namespace faultlab::core
