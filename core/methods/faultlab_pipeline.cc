// The diagnosis of faultlab's own runs (core/diagnosis) behind the interface of this folder: the
// detection bank of core/detection at its stated rate of false alarms, isolation and identification
// of core/isolation, with the calibration that all methods get. Tuning: none here.
#include <limits>

#include "core/diagnosis/pipeline.h"
#include "core/methods/method_list.h"

namespace faultlab::core {
namespace {

class FaultlabPipeline : public Method {
 public:
  explicit FaultlabPipeline(const MethodTask& task) : pipeline_(OptionsFrom(task)) {}

  void Push(const Sample& sample, const Observation&) override {
    pipeline_.Push(sample);
    Solve();
    if (pipeline_.verdict().detected_at_s) detected_ = true;
  }
  double statistic() const override { return detected_ ? 1.0 : 0.0; }
  MethodFinding Diagnose() override {
    MethodFinding finding{Answer::kNotYet, Answer::kNotYet, {}, 0};
    const Verdict& verdict = pipeline_.verdict();
    if (verdict.kind != VerdictKind::kFault || verdict.group.empty()) return finding;
    for (const Candidate& candidate : verdict.candidates) {
      finding.candidates.push_back({candidate.component, candidate.value, candidate.margin});
    }
    finding.named = std::min(verdict.group.size(), finding.candidates.size());
    finding.isolation = Answer::kGiven;
    finding.identification = Answer::kGiven;
    return finding;
  }
  std::size_t bytes() const override {
    // The record that its fits use, bounded by AlarmRecord, and its estimators' windows.
    constexpr std::size_t kSamples = 2600;
    return kSamples * sizeof(Sample);
  }

 private:
  static DiagnosisOptions OptionsFrom(const MethodTask& task) {
    DiagnosisOptions options = OptionsOf(*task.bench, task.period_s);
    options.calibration = task.calibration;
    options.channels = task.channels;
    options.healthy_from_s = 0.0;
    return options;
  }
  void Solve() {
    while (std::optional<DiagnosisTask> task = pipeline_.TakeTask()) {
      pipeline_.Accept(RunTask(*task));
    }
  }

  Pipeline pipeline_;
  bool detected_ = false;
};

}  // namespace

std::unique_ptr<Method> MakeFaultlab(const MethodTask& task) {
  return std::make_unique<FaultlabPipeline>(task);
}

}  // namespace faultlab::core
