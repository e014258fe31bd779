#include "server/run/diagnosis_worker.h"

#include <exception>

namespace faultlab::server {

void SolverBox::Put(core::DiagnosisResult result) {
  {
    const std::lock_guard lock(mutex_);
    result_ = std::move(result);
  }
  filled_.notify_all();
}

std::optional<core::DiagnosisResult> SolverBox::Take(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  if (patience.count() > 0) {
    filled_.wait_for(lock, patience, [this] { return result_.has_value(); });
  }
  return std::exchange(result_, std::nullopt);
}

DiagnosisWorker::DiagnosisWorker() : thread_([this] { Loop(); }) {}

DiagnosisWorker::~DiagnosisWorker() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void DiagnosisWorker::Submit(core::DiagnosisTask task, std::shared_ptr<SolverBox> box) {
  {
    const std::lock_guard lock(mutex_);
    queue_.emplace_back(std::move(task), std::move(box));
  }
  changed_.notify_all();
}

void DiagnosisWorker::Loop() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stop_ || !queue_.empty(); });
    if (stop_) return;
    auto [task, box] = std::move(queue_.front());
    queue_.pop_front();
    if (box.use_count() == 1) continue;  // its run has ended
    lock.unlock();
    core::DiagnosisResult result;
    try {
      result = core::RunTask(task);
    } catch (const std::exception& error) {
      // An error in one fit must not end the others: the pipeline gets a result without an answer.
      result =
          core::Unanswered(task, {core::ErrorCode::kInvalid, error.what(), "solver", "internal"});
    }
    box->Put(std::move(result));
    lock.lock();
  }
}

}  // namespace faultlab::server
