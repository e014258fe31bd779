#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "core/diagnosis/diagnosis_task.h"

namespace faultlab::server {

/// An error in one fit must not end the others, nor the run: the result has no answer then.
core::DiagnosisResult Solve(const core::DiagnosisTask& task);

/// Receives the result of a run's task; the run checks it between two samples.
class SolverBox {
 public:
  void Put(core::DiagnosisResult result);
  std::optional<core::DiagnosisResult> Take();  ///< the result if there is one

 private:
  std::mutex mutex_;
  std::optional<core::DiagnosisResult> result_;
};

/// One thread for the fits of all runs in real time: a fit never delays a sample. A pipeline has at
/// most one task out, so the queue is no longer than the number of runs.
class DiagnosisWorker {
 public:
  DiagnosisWorker();
  ~DiagnosisWorker();  ///< drops queued tasks
  DiagnosisWorker(const DiagnosisWorker&) = delete;
  DiagnosisWorker& operator=(const DiagnosisWorker&) = delete;

  void Submit(core::DiagnosisTask task, std::shared_ptr<SolverBox> box);

 private:
  void Loop();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::pair<core::DiagnosisTask, std::shared_ptr<SolverBox>>> queue_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace faultlab::server
