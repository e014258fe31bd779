#include "hardware/simulated/rig_farm.h"

#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "core/types/check.h"

namespace faultlab::hardware {
namespace {

constexpr Nanoseconds kSlot = std::chrono::milliseconds(10);

class Farm final : public RigFarm {
 public:
  explicit Farm(std::size_t max_tasks) : max_tasks_(max_tasks) {
    thread_ = std::thread([this] { Loop(); });
  }
  ~Farm() override {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    arrived_.notify_all();
    thread_.join();
  }

  std::unique_ptr<Handle> Launch(LoopTask& task) override {
    auto entry = std::make_shared<Entry>();
    entry->task = &task;
    {
      const std::lock_guard lock(mutex_);
      LAB_CHECK(tasks_ < max_tasks_, tasks_);
      ++tasks_;
      arriving_.push_back(entry);
    }
    arrived_.notify_all();
    return std::make_unique<FarmHandle>(*this, std::move(entry));
  }

  bool fifo() const override { return false; }

  Load load() const override {
    const std::lock_guard lock(mutex_);
    Load load = load_;
    load.tasks = tasks_;
    const Nanoseconds alive = clock_->Now() - began_;
    load.busy_share = alive.count() > 0
                          ? static_cast<double>(busy_.count()) / static_cast<double>(alive.count())
                          : 0.0;
    return load;
  }

 private:
  struct Entry {
    LoopTask* task = nullptr;
    Nanoseconds next{0};   ///< deadline on the task's clock
    Nanoseconds until{0};  ///< the task's time that has passed in real time
    bool begun = false;
    bool over = false;  ///< guarded by the farm's mutex
  };

  class FarmHandle final : public Handle {
   public:
    FarmHandle(Farm& farm, std::shared_ptr<Entry> entry) : farm_(farm), entry_(std::move(entry)) {}
    ~FarmHandle() override {
      std::unique_lock lock(farm_.mutex_);
      farm_.ended_.wait(lock, [this] { return entry_->over; });
    }

   private:
    Farm& farm_;
    const std::shared_ptr<Entry> entry_;
  };

  /// @param late  since the slot was due: other tasks of the slot went first
  /// @returns false when the task is over.
  static bool StepToSlotEnd(Entry& entry, Nanoseconds late) {
    if (!entry.begun) {
      entry.begun = true;
      entry.until = entry.task->clock().Now();
      const std::optional<Nanoseconds> next = entry.task->Step({});
      if (!next) return false;
      entry.next = *next;
    }
    entry.until += kSlot;
    while (entry.next < entry.until) {
      Wake wake = entry.task->clock().SleepUntil(entry.next);
      wake.wall_lateness = late;
      const std::optional<Nanoseconds> next = entry.task->Step(wake);
      if (!next) return false;
      entry.next = *next;
    }
    return true;
  }

  void Loop() {
    std::vector<std::shared_ptr<Entry>> running;
    Nanoseconds slot_at = clock_->Now();
    began_ = slot_at;
    while (true) {
      {
        std::unique_lock lock(mutex_);
        if (running.empty() && arriving_.empty()) {
          // Nobody to step: no wake-ups, and the next slot begins when somebody comes.
          arrived_.wait(lock, [this] { return stop_ || !arriving_.empty(); });
          slot_at = clock_->Now();
        }
        if (stop_) return;
        for (std::shared_ptr<Entry>& entry : arriving_) running.push_back(std::move(entry));
        arriving_.clear();
      }
      const Nanoseconds begin = clock_->Now();
      std::vector<std::shared_ptr<Entry>> over;
      std::erase_if(running, [&](std::shared_ptr<Entry>& entry) {
        if (StepToSlotEnd(*entry, clock_->Now() - slot_at)) return false;
        over.push_back(std::move(entry));
        return true;
      });
      const Nanoseconds end = clock_->Now();
      {
        const std::lock_guard lock(mutex_);
        for (const std::shared_ptr<Entry>& entry : over) entry->over = true;
        tasks_ -= over.size();
        busy_ += end - begin;
        ++load_.slots;
        if (begin - slot_at >= kSlot) ++load_.late_slots;
      }
      if (!over.empty()) ended_.notify_all();
      slot_at += kSlot;
      (void)clock_->SleepUntil(slot_at);
    }
  }

  const std::size_t max_tasks_;
  const std::shared_ptr<Clock> clock_ = MakeSteadyClock();
  mutable std::mutex mutex_;
  std::condition_variable ended_;
  std::condition_variable arrived_;
  std::vector<std::shared_ptr<Entry>> arriving_;
  std::size_t tasks_ = 0;
  Load load_;
  Nanoseconds busy_{0};
  Nanoseconds began_{0};
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace

std::shared_ptr<RigFarm> MakeRigFarm(std::size_t max_tasks) {
  return std::make_shared<Farm>(max_tasks);
}

}  // namespace faultlab::hardware
