#!/usr/bin/env python3
"""Rolling least squares of y = phi' theta (3 parameters, window 100) the fast way in numpy:
differences of cumulative sums and one batched solve, without errors or condition numbers.
Prints nanoseconds of CPU time per sample, best of five."""

import time

import numpy as np

SAMPLES, WINDOW = 200_000, 100


def make_record(rng):
    u = rng.integers(2, 4, SAMPLES).astype(float)
    y = np.empty(SAMPLES)
    state, before = 4.8, 2.0
    for k in range(SAMPLES):
        state = 2.1146 * u[k] - 1.0975 * before + 0.5751 * state
        before = u[k]
        y[k] = state
    return u, y + rng.normal(0.0, 0.015, SAMPLES)


def rolling(u, y):
    rows = np.stack([u[1:], u[:-1], -y[:-1], y[1:]], axis=1)
    i, j = np.tril_indices(4)
    sums = np.cumsum(rows[:, i] * rows[:, j], axis=0)
    sums[WINDOW:] -= sums[:-WINDOW].copy()
    sums = sums[WINDOW - 1:]
    normal = np.empty((len(sums), 4, 4))
    normal[:, i, j] = sums
    normal[:, j, i] = sums
    return np.linalg.solve(normal[:, :3, :3], normal[:, :3, 3:])[..., 0]


def main():
    u, y = make_record(np.random.default_rng(1))
    best = float("inf")
    for _ in range(5):
        start = time.process_time()
        theta = rolling(u, y)
        best = min(best, time.process_time() - start)
    assert abs(theta[-1, 0] - 2.1146) < 0.1
    print(f"{best / SAMPLES * 1e9:.1f}")


if __name__ == "__main__":
    main()
