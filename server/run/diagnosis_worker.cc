#include "server/run/diagnosis_worker.h"

#include <exception>

namespace faultlab::server {

core::DiagnosisResult Solve(const core::DiagnosisTask& task) {
  try {
    return core::RunTask(task);
  } catch (const std::exception& error) {
    return core::Unanswered(task, {core::ErrorCode::kInvalid, error.what(), "solver", "internal"});
  }
}

void SolverBox::Put(core::DiagnosisResult result) {
  const std::lock_guard lock(mutex_);
  result_ = std::move(result);
}

std::optional<core::DiagnosisResult> SolverBox::Take() {
  const std::lock_guard lock(mutex_);
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
    box->Put(Solve(task));
    lock.lock();
  }
}

}  // namespace faultlab::server
