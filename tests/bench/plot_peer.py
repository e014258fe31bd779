"""Draws the picture of plot_bench.cc with matplotlib and prints the median milliseconds."""
import io
import math
import statistics
import time

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

x = [0.01 * k for k in range(2000)]
y = [[t + 0.3 * math.sin(0.02 * k) + 0.2 * math.sin(12.9898 * k * (t + 1)) for k in range(2000)] for t in range(3)]


def draw():
    figure, axes = plt.subplots(figsize=(16, 9), dpi=100)
    for t in range(3):
        axes.plot(x, y[t], label=f"trace {t + 1}")
    axes.set(title="Three traces", xlabel="Time t (s)", ylabel="$U_m$ (V)")
    axes.grid(True)
    axes.legend()
    figure.savefig(io.BytesIO(), format="png")
    plt.close(figure)


draw()
times = []
for _ in range(11):
    start = time.perf_counter()
    draw()
    times.append(1e3 * (time.perf_counter() - start))
print(statistics.median(times))
