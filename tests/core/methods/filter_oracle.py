"""An independent implementation of core/methods' recursive filters, by numpy alone.

Reads one JSON object from the file named on the command line: the constants of a rig, and the inputs and readings of a
record. Prints, as JSON, the estimate after every 50th sample of
  ekf, ukf   log(Ra) by the extended and the unscented Kalman filter
  rls        (b0d, b1d, a1d, c) by least squares with forgetting, solved anew as a weighted batch
It shares nothing with the C++ code: the model comes from the differential equations, its exponentials from eigenvalues,
the unscented filter's square root from eigenvectors.
"""
import json
import sys

import numpy as np


def sampled(rig, ra):
    """x+ = phi x + g_prev u_prev + g u + g_torque s Mc, x = (z, i, w, d) at the reading."""
    k, a, lag, r1 = rig["k"], rig["direct"], rig["lag"], rig["r1"]
    la, ke, kt, j, b, tau = (rig[name] for name in ("la", "ke", "kt", "j", "b", "tau"))
    system = np.array([
        [-1 / lag, 0, 0, 0],
        [k * (1 - a) / la, -(ra + r1) / la, -ke / la, 0],
        [0, kt / j, -b / j, -1 / j],
        [0, 0, 0, -1 / tau],
    ])
    by_input = np.array([1 / lag, k * a / la, 0, 0])
    by_torque = np.array([0, 0, -1 / j, 0])
    values, vectors = np.linalg.eig(system)

    def flow(t, drive):
        phi = (vectors * np.exp(values * t)) @ np.linalg.inv(vectors)
        gamma = np.linalg.solve(system, (phi - np.eye(4)) @ drive)
        return np.real(phi), np.real(gamma)

    period, delta = rig["period"], rig["delta"]
    phi, g_torque = flow(period, by_torque)
    _, g_before = flow(period - delta, by_input)
    phi_delta, g_after = flow(delta, by_input)
    return {
        "phi": phi, "g_prev": phi_delta @ g_before, "g": g_after, "g_torque": g_torque,
        "c": np.array([k * (1 - a), -r1, 0, 0]), "d": k * a,
    }


def step(rig, model, x, u_prev, u):
    sign = np.clip(x[2] / rig["creep"], -1, 1)
    return model["phi"] @ x + model["g_prev"] * u_prev + model["g"] * u + model["g_torque"] * (sign * rig["mc"])


def output(model, x, u):
    return model["c"] @ x + model["d"] * u


def noise_of(rig):
    torque = rig["friction"] ** 2 * (1 - np.exp(-2 * rig["period"] / rig["tau"]))
    return torque, rig["um_noise"] ** 2


def extended(rig, record, x, p):
    torque, reading = noise_of(rig)
    h = 1e-4
    estimates = []
    for n, (u_prev, u, y) in enumerate(record):
        here, there = sampled(rig, np.exp(x[4])), sampled(rig, np.exp(x[4] + h))
        ahead = step(rig, here, x[:4], u_prev, u)
        f = np.eye(5)
        f[:4, :4] = here["phi"]
        f[:4, 4] = (step(rig, there, x[:4], u_prev, u) - ahead) / h
        p = f @ p @ f.T + np.diag([0, 0, 0, torque, rig["walk"] ** 2])
        x = np.append(ahead, x[4])
        row = np.append(here["c"], (output(there, ahead, u) - output(here, ahead, u)) / h)
        s = row @ p @ row + reading
        gain = p @ row / s
        x = x + gain * (y - output(here, ahead, u))
        p = p - np.outer(gain, row @ p)
        p = (p + p.T) / 2
        if n % 50 == 49:
            estimates.append(x[4])
    return estimates


def sigma_points(x, p):
    n = len(x)
    values, vectors = np.linalg.eigh(p)
    root = vectors * np.sqrt(np.maximum(values, 0) * (n + 1))
    points = [x] + [x + root[:, i] for i in range(n)] + [x - root[:, i] for i in range(n)]
    weights = np.array([1 / (n + 1)] + [1 / (2 * (n + 1))] * (2 * n))
    return np.array(points), weights


def unscented(rig, record, x, p):
    torque, reading = noise_of(rig)
    estimates = []
    for n, (u_prev, u, y) in enumerate(record):
        points, weights = sigma_points(x, p)
        for q in points:
            q[:4] = step(rig, sampled(rig, np.exp(q[4])), q[:4].copy(), u_prev, u)
        x = weights @ points
        off = points - x
        p = (off.T * weights) @ off + np.diag([0, 0, 0, torque, rig["walk"] ** 2])
        points, weights = sigma_points(x, p)
        outputs = np.array([output(sampled(rig, np.exp(q[4])), q[:4], u) for q in points])
        mean = weights @ outputs
        s = weights @ (outputs - mean) ** 2 + reading
        gain = ((points - x).T * weights) @ (outputs - mean) / s
        x = x + gain * (y - mean)
        p = p - s * np.outer(gain, gain)
        p = (p + p.T) / 2
        if n % 50 == 49:
            estimates.append(x[4])
    return estimates


def forgetting(record, theta, p, forget):
    start = np.linalg.inv(p)
    rows, right, estimates = [], [], []
    for n, (_, u, y) in enumerate(record):
        if n > 0:
            rows.append([u, record[n - 1][1], -record[n - 1][2], 1])
            right.append(y)
        if n % 50 == 49:
            a, b = np.array(rows), np.array(right)
            weights = forget ** np.arange(len(b) - 1, -1, -1)
            before = forget ** len(b) * start
            estimates.append(list(np.linalg.solve((a.T * weights) @ a + before, (a.T * weights) @ b + before @ theta)))
    return estimates


def main():
    with open(sys.argv[1], encoding="ascii") as file:
        task = json.load(file)
    rig, record = task["rig"], task["record"]
    x = np.array(task["x"], dtype=float)
    p = np.diag(np.array(task["p"], dtype=float))
    rls = task["rls"]
    print(json.dumps({
        "ekf": extended(rig, record, x.copy(), p.copy()),
        "ukf": unscented(rig, record, x.copy(), p.copy()),
        "rls": forgetting(record, np.array(rls["theta"], dtype=float), rls["p"] * np.eye(4), rls["forget"]),
    }))


main()
