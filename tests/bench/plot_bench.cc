// The cost of a picture. Goal for 1600x900 pixels and 3 x 2000 points: <= 60 ms, and <= 0.4 x
// matplotlib. The peer runs in the same call if python3 has matplotlib.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "server/csv/csv_record.h"
#include "server/csv/csv_writer.h"
#include "server/plots/render.h"

namespace {

using namespace faultlab;  // NOLINT(google-build-using-namespace)
using server::Figure;

constexpr int kPoints = 2000;
constexpr double kGoalMs = 60.0;
constexpr double kGoalRatio = 0.4;

/// Three noisy traces in one panel, the same as in tests/bench/plot_peer.py.
Figure ThreeTraces() {
  Figure figure;
  figure.title = "Three traces";
  figure.x = {"Time t", "s", std::nullopt};
  server::Panel panel;
  panel.y = {"U_{m}", "V", std::nullopt};
  const server::Ink inks[] = {server::Ink::kBlue, server::Ink::kVermilion, server::Ink::kGreen};
  for (int trace = 0; trace < 3; ++trace) {
    server::Series series;
    series.name = "trace " + std::to_string(trace + 1);
    series.ink = inks[trace];
    for (int k = 0; k < kPoints; ++k) {
      series.x.push_back(0.01 * k);
      series.y.push_back(trace + 0.3 * std::sin(0.02 * k) +
                         0.2 * std::sin(12.9898 * k * (trace + 1)));
    }
    panel.series.push_back(std::move(series));
  }
  figure.panels.push_back(std::move(panel));
  return figure;
}

void RenderThreeTraces(benchmark::State& state) {
  const Figure figure = ThreeTraces();
  server::RenderOptions options;
  options.scale = static_cast<int>(state.range(0));
  std::size_t bytes = 0;
  for (auto _ : state) {
    bytes = server::RenderPng(figure, options).value().size();
  }
  state.counters["png_kB"] = static_cast<double>(bytes) / 1e3;
}
BENCHMARK(RenderThreeTraces)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);

void ReadRecording(benchmark::State& state) {
  std::vector<core::Sample> samples(60'000);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double t = 0.01 * static_cast<double>(k);
    samples[k] = {static_cast<std::int64_t>(k), t, 2.5, std::sin(t), core::kAbsent, std::cos(t), t};
  }
  const std::string text = server::FormatCsv(samples);
  for (auto _ : state) {
    benchmark::DoNotOptimize(server::ParseCsv(text, "bench"));
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations() * text.size()));
}
BENCHMARK(ReadRecording)->Unit(benchmark::kMillisecond);

double MedianRenderMs() {
  using Clock = std::chrono::steady_clock;
  const Figure figure = ThreeTraces();
  std::vector<double> times_ms;
  for (int i = 0; i < 11; ++i) {
    const Clock::time_point start = Clock::now();
    benchmark::DoNotOptimize(server::RenderPng(figure));
    times_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
  }
  std::nth_element(times_ms.begin(), times_ms.begin() + 5, times_ms.end());
  return times_ms[5];
}

/// Milliseconds that matplotlib takes, or a negative number without it.
double PeerMs() {
  std::FILE* peer = ::popen("python3 " PLOT_PEER " 2>/dev/null", "r");
  if (peer == nullptr) {
    return -1.0;
  }
  double ms = -1.0;
  const bool read = std::fscanf(peer, "%lf", &ms) == 1;
  ::pclose(peer);
  return read ? ms : -1.0;
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  const double ours_ms = MedianRenderMs();
  std::printf("1600 x 900, 3 x %d points, PNG: %.1f ms (goal %.0f)\n", kPoints, ours_ms, kGoalMs);
  const double peer_ms = PeerMs();
  if (peer_ms > 0.0) {
    std::printf("matplotlib, same picture: %.1f ms; ratio %.2f (goal %.1f)\n",
                peer_ms,
                ours_ms / peer_ms,
                kGoalRatio);
  } else {
    std::printf("matplotlib: not installed, no ratio\n");
  }
  return 0;
}
