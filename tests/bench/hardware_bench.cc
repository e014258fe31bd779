// The figures of the hardware layer, printed by build/release/tests/bench/hardware_bench. It is a
// program, not a Google Benchmark, because most of what it measures is waiting. About 40 s.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/diagnosis/pipeline.h"
#include "core/signals/random.h"
#include "hardware/lcm/channels.h"
#include "hardware/lcm/remote_rig.h"
#include "hardware/lcm/rig_agent.h"
#include "hardware/run_loop.h"
#include "hardware/simulated/simulated_rig.h"
#include "tests/hardware/lossy_bus.h"
#include "tests/hardware/remote_world.h"
#include "tests/paper_rig.h"

namespace faultlab::hardware {
namespace {

constexpr Epoch kEpoch{1};
using Time = std::chrono::steady_clock;

double Seconds(Time::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

RunPlan RandomPlan(int samples) {
  RunPlan plan;
  core::Random random(1);
  for (int k = 0; k < samples; ++k) plan.uc_v.push_back(random.Uniform() < 0.5 ? 2.0 : 3.0);
  return plan;
}

/// `count` simulated rigs in real time, each on its thread; this thread runs their samples through
/// the whole pipeline. The shares of a core of the rigs' threads and of this one are added.
void Rigs(int count) {
  std::vector<std::unique_ptr<Rig>> rigs;
  std::vector<core::Pipeline> pipelines;
  for (int i = 0; i < count; ++i) {
    SimulatedRigOptions options;
    options.queue_messages = 1024;
    options.watchdog = std::chrono::seconds(10);
    rigs.push_back(MakeSimulatedRig(options));
    pipelines.emplace_back(paper::Options());
    RunPlan plan = RandomPlan(300);
    plan.seed = static_cast<std::uint64_t>(i);
    (void)rigs.back()->Arm(std::move(plan), kEpoch);
  }
  for (auto& rig : rigs) (void)rig->Start(kEpoch);
  const std::clock_t cpu_begin = std::clock();
  const Time::time_point begin = Time::now();
  Time::duration busy{0};
  std::size_t open = rigs.size();
  std::vector<bool> ended(rigs.size());
  std::vector<RigMessage> messages;
  std::size_t samples = 0;
  std::size_t stopped = 0;
  while (open > 0) {
    const Time::time_point sweep = Time::now();
    for (std::size_t i = 0; i < rigs.size(); ++i) {
      if (ended[i]) continue;
      messages.clear();
      const ReadStatus status = rigs[i]->Read(messages, std::chrono::milliseconds(0));
      for (const RigMessage& message : messages) {
        if (const auto* sample = std::get_if<core::Sample>(&message)) {
          (void)pipelines[i].Push(*sample);
          ++samples;
        } else if (std::get<RigEvent>(message).kind == RigEventKind::kStopped) {
          ++stopped;
        }
      }
      if (status == ReadStatus::kEnded) {
        ended[i] = true;
        --open;
      }
    }
    busy += Time::now() - sweep;
    std::this_thread::sleep_until(sweep + std::chrono::milliseconds(20));
  }
  const double wall_s = Seconds(Time::now() - begin);
  const double pipeline_share = Seconds(busy) / wall_s;
  const double rig_share =
      static_cast<double>(std::clock() - cpu_begin) / CLOCKS_PER_SEC / wall_s - pipeline_share;
  std::printf(
      "%5d rigs: %zu samples in %.2f s (3 s of each), rigs %.0f %% + pipelines %.0f %% of a "
      "core, %zu failed -> %.0f rigs a core\n",
      count,
      samples,
      wall_s,
      rig_share * 100.0,
      pipeline_share * 100.0,
      stopped,
      count / (rig_share + pipeline_share));
}

void PrintTimes(const char* name, const TimeHistogram& times) {
  std::printf("%-34s p50 <= %.0f us, p99 <= %.0f us, worst %.0f us, n = %lu",
              name,
              times.QuantileBound(0.5) * 1e6,
              times.QuantileBound(0.99) * 1e6,
              times.worst_s * 1e6,
              static_cast<unsigned long>(times.count()));
}

void PrintLateness(const char* name, const LoopQuality& quality) {
  PrintTimes(name, quality.lateness);
  std::printf(", %lu overruns%s\n",
              static_cast<unsigned long>(quality.overruns),
              quality.fifo ? " (SCHED_FIFO)" : "");
}

/// Lateness of a bare task at 100 Hz.
LoopQuality QualityOfTicks(int ticks, int fifo_priority) {
  LoopQuality quality;
  const std::shared_ptr<Clock> clock = MakeSteadyClock();
  Nanoseconds next = clock->Now();
  std::jthread([&] {
    quality.fifo = AskForFifo(fifo_priority);
    RunLoop(*clock, [&, left = ticks, first = true](const Wake& wake) mutable {
      if (!std::exchange(first, false)) {
        quality.lateness.Count(static_cast<double>(wake.lateness.count()) * 1e-9);
        if (wake.lateness >= std::chrono::milliseconds(10)) ++quality.overruns;
      }
      next += std::chrono::milliseconds(10);
      return left-- == 0 ? std::nullopt : std::optional(next);
    });
  }).join();
  return quality;
}

void LoopLateness(bool loaded) {
  std::atomic<bool> stop{false};
  std::vector<std::thread> load;
  for (unsigned i = 0; loaded && i < std::thread::hardware_concurrency(); ++i) {
    load.emplace_back([&stop] {
      volatile double x = 1.0;
      while (!stop) x = x * 1.0000001;
    });
  }
  for (const int priority : {0, 50}) {
    PrintLateness(loaded ? "loop, all cores busy" : "loop, machine as it is",
                  QualityOfTicks(500, priority));
  }
  stop = true;
  for (std::thread& thread : load) thread.join();
}

/// The time from Command to the event of its action, on a real-time rig; ticks are 10 ms.
void CommandToActuation() {
  SimulatedRigOptions options;
  const auto rig = MakeSimulatedRig(options);
  (void)rig->Arm(RandomPlan(2000), kEpoch);
  (void)rig->Start(kEpoch);
  std::vector<double> latencies_ms;
  std::vector<RigMessage> messages;
  bool high = false;
  for (int i = 0; i < 60; ++i) {
    high = !high;
    const Time::time_point asked = Time::now();
    (void)rig->Command(kEpoch,
                       {.kind = RigCommand::Kind::kSetComponent,
                        .component = paper::kRa,
                        .value = high ? 9.0 : 7.41});
    for (bool acted = false; !acted;) {
      messages.clear();
      (void)rig->Read(messages, std::chrono::milliseconds(20));
      for (const RigMessage& message : messages) {
        const auto* event = std::get_if<RigEvent>(&message);
        acted = acted || (event != nullptr && event->kind == RigEventKind::kRelayConfirmed);
      }
    }
    latencies_ms.push_back(Seconds(Time::now() - asked) * 1e3);
    std::this_thread::sleep_for(std::chrono::milliseconds(7 + i % 11));
  }
  std::sort(latencies_ms.begin(), latencies_ms.end());
  std::printf(
      "command to confirmation, read back with its sample: p50 %.1f ms, p95 %.1f ms, worst "
      "%.1f ms (goal: one tick of 10 ms plus 1 ms, plus delta 9.5 ms until it is read)\n",
      latencies_ms[latencies_ms.size() / 2],
      latencies_ms[latencies_ms.size() * 95 / 100],
      latencies_ms.back());
}

/// Messages and bytes of one remote rig, and the time from the end of a cut to the last hole
/// filled.
void Bus() {
  LossyBus bus(Weather{}, 1);
  RigAgentSettings settings;
  settings.watchdog = std::chrono::seconds(60);
  settings.lease = std::chrono::seconds(65);
  AgentThread agent(bus, 1.0, settings);
  ServerThread server(bus, 1.0, "bench");
  server.WaitUntilHeard();
  if (!server.rig().Arm(RandomPlan(1000), kEpoch).ok()) return;
  const std::size_t before = bus.overheard().size();
  (void)server.rig().Start(kEpoch);
  std::vector<RigMessage> messages;
  std::size_t samples = 0;
  Time::time_point mended{};
  double recovery_s = 0.0;
  bool was_cut = false;
  std::size_t at_cut = 0;
  std::thread mender;
  while (server.rig().Read(messages, std::chrono::milliseconds(100)) == ReadStatus::kMore) {
    for (const RigMessage& message : messages) {
      if (std::holds_alternative<core::Sample>(message)) ++samples;
    }
    messages.clear();
    if (samples >= 300 && !was_cut) {
      was_cut = true;
      const auto overheard = bus.overheard();
      std::size_t bytes = 0;
      for (std::size_t i = before; i < overheard.size(); ++i) {
        bytes += overheard[i].first.size() + overheard[i].second.size();
      }
      const double seconds = static_cast<double>(samples) / 100.0;
      std::printf("one remote rig at 100 Hz: %.0f messages/s, %.1f kB/s both ways\n",
                  static_cast<double>(overheard.size() - before) / seconds,
                  static_cast<double>(bytes) / seconds / 1e3);
      at_cut = samples;
      bus.SetCut(true);
      mender = std::thread([&] {
        std::this_thread::sleep_for(std::chrono::seconds(5));
        mended = Time::now();
        bus.SetCut(false);
      });
    }
    if (was_cut && recovery_s == 0.0 && samples > at_cut + 480) {
      recovery_s = Seconds(Time::now() - mended);
    }
  }
  mender.join();
  std::printf("cut of 5 s: whole again %.3f s after its end, %zu samples of 1000, %ld by refill\n",
              recovery_s,
              samples + std::count_if(messages.begin(),
                                      messages.end(),
                                      [](const RigMessage& m) {
                                        return std::holds_alternative<core::Sample>(m);
                                      }),
              static_cast<long>(server.rig().info().gaps_refilled));
}

}  // namespace
}  // namespace faultlab::hardware

int main(int argc, char** argv) {
  using namespace faultlab::hardware;
  const std::string only = argc > 1 ? argv[1] : "";
  if (only.empty() || only == "rigs") {
    for (const int count : {32, 200}) Rigs(count);
  }
  if (only.empty() || only == "loop") {
    LoopLateness(false);
    LoopLateness(true);
  }
  if (only.empty() || only == "command") CommandToActuation();
  if (only.empty() || only == "bus") Bus();
  return 0;
}
