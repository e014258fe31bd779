// A program: trains the network of core/methods/neural_network.h on simulated runs of the paper's
// bench and writes core/methods/network_weights.cc.
//   train_network [FILE.cc] [RECORDS] [ITERATIONS]
// Each record has 5 s of a healthy rig and one fault at 8 s; value, component and input are drawn.
// OpenCV's ml is linked by this program alone.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <opencv2/ml.hpp>
#include <string>
#include <vector>

#include "core/isolation/profile_cost.h"
#include "core/methods/hypotheses.h"
#include "core/methods/method_session.h"
#include "core/methods/neural_network.h"
#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"
#include "core/signals/random.h"
#include "tests/paper_bench.h"

namespace faultlab {
namespace {

using namespace core;

constexpr std::array kLayers = {kNetworkInputs, 32, 16, 8};
constexpr std::uint64_t kSeed = 900'000;
constexpr double kFaultAt_s = 8.0;
constexpr int kSamples = 1700;

struct Vectors {
  std::vector<NetworkInputs> inputs;
  std::vector<std::vector<float>> outputs;
  std::vector<int> classes;
};

std::vector<Sample> Simulated(std::uint64_t seed, const std::vector<Fault>& faults) {
  PrbsSpec spec;
  spec.seed = 1 + seed % 1000;
  return SimulateRecord(paper::Hardware(),
                        paper::Plant(),
                        MakePrbs(spec, kSamples, paper::kPeriodS),
                        faults,
                        seed,
                        paper::kPeriodS);
}

void AddRecord(const MethodTask& like,
               const std::vector<Component>& components,
               std::uint64_t seed,
               Vectors& out) {
  Random random(StreamSeed(seed, 7));
  const auto which = static_cast<std::size_t>(random.Below(components.size()));
  const Component component = components[which];
  const double start = LogStart(like, component);
  const ValueRange range = RangeOf(component);
  constexpr double kLeast = 0.4;  // of a logarithm: smaller faults look healthy to any window
  constexpr double kMost = 6.0;
  double log_value = start;
  const double least = std::max(kLeast, component.info().least_visible > 0.0 ? 2.5 : kLeast);
  while (std::abs(log_value - start) < least) {
    log_value = random.Uniform(std::max(std::log(range.low), start - kMost),
                               std::min(std::log(range.high), start + kMost + 2.0));
  }
  Fault fault;
  fault.component = component;
  fault.value = std::exp(log_value);
  fault.at_s = kFaultAt_s;
  const std::vector<Sample> samples = Simulated(seed, {fault});
  ObservationBuilder builder(paper::Bench().readings(), Channels::kUmOnly, paper::kPeriodS, 10.0);
  MethodTask task = like;
  task.healthy.clear();
  std::vector<Observation> rest;
  for (const Sample& sample : samples) {
    Observation observation;
    if (!builder.Push(sample, observation)) continue;
    if (sample.t_s < 0.5) continue;
    (sample.t_s < 5.0 ? task.healthy : rest).push_back(observation);
  }
  NetworkWindow window(task);
  for (std::size_t k = 0; k < rest.size(); ++k) {
    window.Push(rest[k]);
    const bool healthy = k >= 100 && k < 300 && k % 45 == 10;
    const bool faulty = k >= 405 && k % 100 == 5;
    if (!healthy && !faulty) continue;
    const auto inputs = window.Inputs();
    if (!inputs) continue;
    std::vector<float> output(kLayers.back(), -0.9F);
    const std::size_t at = healthy ? 0 : 1 + which;
    output[at] = 0.9F;
    output.back() = healthy ? 0.0F : static_cast<float>((log_value - start) / kNetworkLogScale);
    out.inputs.push_back(*inputs);
    out.outputs.push_back(output);
    out.classes.push_back(static_cast<int>(at));
  }
}

cv::Mat Inputs(const Vectors& v) {
  cv::Mat all(static_cast<int>(v.inputs.size()), kNetworkInputs, CV_32F);
  for (int r = 0; r < all.rows; ++r) {
    for (int c = 0; c < all.cols; ++c) {
      all.at<float>(r, c) =
          static_cast<float>(v.inputs[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)]);
    }
  }
  return all;
}

cv::Mat Outputs(const Vectors& v) {
  cv::Mat all(static_cast<int>(v.outputs.size()), kLayers.back(), CV_32F);
  for (int r = 0; r < all.rows; ++r) {
    for (int c = 0; c < all.cols; ++c) {
      all.at<float>(r, c) = v.outputs[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
    }
  }
  return all;
}

std::vector<float> WeightsOf(const cv::ml::ANN_MLP& net) {
  std::vector<float> weights;
  for (int layer = 1; layer < static_cast<int>(kLayers.size()); ++layer) {
    const cv::Mat w = net.getWeights(layer);  // rows: inputs, then the bias; a column each output
    for (int out = 0; out < w.cols; ++out) {
      weights.push_back(static_cast<float>(w.at<double>(w.rows - 1, out)));
      for (int in = 0; in + 1 < w.rows; ++in) {
        weights.push_back(static_cast<float>(w.at<double>(in, out)));
      }
    }
  }
  return weights;
}

int ClassOf(const std::vector<double>& outputs) {
  return static_cast<int>(std::max_element(outputs.begin(), outputs.end() - 1) - outputs.begin());
}

void Write(const std::string& path,
           const std::string& recipe,
           const std::vector<Component>& components,
           const std::vector<float>& weights) {
  std::ofstream out(path);
  out << "// Written by tests/bench/train_network.cc; do not edit.\n// clang-format off\n"
      << "#include <array>\n\n#include \"core/methods/neural_network.h\"\n\nnamespace "
         "faultlab::core {\n\nconst Network& TrainedNetwork() {\n  static constexpr "
         "std::array<int, "
      << components.size() << "> kComponents = {";
  for (std::size_t i = 0; i < components.size(); ++i) {
    out << (i > 0 ? ", " : "") << Index(components[i]);
  }
  out << "};\n  static constexpr std::array<int, " << kLayers.size() << "> kLayers = {";
  for (std::size_t i = 0; i < kLayers.size(); ++i) out << (i > 0 ? ", " : "") << kLayers[i];
  out << "};\n  static constexpr std::array<float, " << weights.size() << "> kWeights = {";
  for (std::size_t i = 0; i < weights.size(); ++i) {
    std::array<char, 32> text;
    std::snprintf(text.data(), text.size(), "%.6gF", static_cast<double>(weights[i]));
    std::string number = text.data();
    if (number.find_first_of(".e") == std::string::npos) number.insert(number.size() - 1, ".0");
    out << (i % 10 == 0 ? "\n      " : " ") << number << ',';
  }
  out << "};\n  static constexpr Network kNetwork = {\n      \"paper\",\n      \"" << recipe
      << "\",\n      kComponents, kLayers, kWeights};\n  return kNetwork;\n}\n\n}  // namespace "
         "faultlab::core\n";
}

int Run(const std::string& path, int records, int iterations) {
  const auto task =
      PrepareMethods(Simulated(kSeed, {}), MethodOptionsOf(paper::Bench(), paper::kPeriodS));
  if (!task) return 1;
  const std::vector<Component> components = DistinctComponents(task.value());
  if (components.size() + 2 != static_cast<std::size_t>(kLayers.back())) return 1;
  Vectors train;
  Vectors test;
  for (int r = 0; r < records; ++r) {
    AddRecord(task.value(),
              components,
              kSeed + 1 + static_cast<std::uint64_t>(r),
              r % 5 == 0 ? test : train);
  }
  cv::setRNGSeed(1);
  const cv::Ptr<cv::ml::ANN_MLP> net = cv::ml::ANN_MLP::create();
  cv::Mat layers(1, static_cast<int>(kLayers.size()), CV_32S);
  for (int i = 0; i < layers.cols; ++i) {
    layers.at<int>(0, i) = kLayers[static_cast<std::size_t>(i)];
  }
  net->setLayerSizes(layers);
  net->setActivationFunction(cv::ml::ANN_MLP::SIGMOID_SYM, 0, 0);
  net->setTrainMethod(cv::ml::ANN_MLP::RPROP, 0.1, 1e-7);
  net->setTermCriteria({cv::TermCriteria::MAX_ITER, iterations, 0.0});
  net->train(cv::ml::TrainData::create(Inputs(train), cv::ml::ROW_SAMPLE, Outputs(train)),
             cv::ml::ANN_MLP::NO_INPUT_SCALE | cv::ml::ANN_MLP::NO_OUTPUT_SCALE);
  const std::vector<float> weights = WeightsOf(*net);
  Network network{"paper", "", {}, kLayers, weights};
  cv::Mat predicted;
  net->predict(Inputs(test), predicted);
  int right = 0;
  double largest = 0.0;
  for (std::size_t i = 0; i < test.inputs.size(); ++i) {
    const std::vector<double> outputs = Evaluate(network, test.inputs[i]);
    right += ClassOf(outputs) == test.classes[i] ? 1 : 0;
    for (int c = 0; c < predicted.cols; ++c) {
      largest = std::max(largest,
                         std::abs(outputs[static_cast<std::size_t>(c)] -
                                  predicted.at<float>(static_cast<int>(i), c)));
    }
  }
  std::array<char, 300> recipe;
  std::snprintf(
      recipe.data(),
      recipe.size(),
      "train_network: %d records from seed %llu, %zu vectors, RPROP %d iterations, layers "
      "6-32-16-8; %.2f %% of %zu test vectors right",
      records,
      static_cast<unsigned long long>(kSeed),
      train.inputs.size(),
      iterations,
      100.0 * right / static_cast<double>(test.inputs.size()),
      test.inputs.size());
  std::printf("%s; core's evaluation is within %.2g of OpenCV's\n", recipe.data(), largest);
  constexpr double kSameOutput = 1e-4;  // single precision of weights
  if (largest > kSameOutput) return 1;
  if (!path.empty()) Write(path, recipe.data(), components, weights);
  return 0;
}

}  // namespace
}  // namespace faultlab

int main(int argc, char** argv) {
  const std::string path = argc > 1 ? argv[1] : "";
  const int records = argc > 2 ? std::atoi(argv[2]) : 2500;
  const int iterations = argc > 3 ? std::atoi(argv[3]) : 1000;
  return faultlab::Run(path, records, iterations);
}
