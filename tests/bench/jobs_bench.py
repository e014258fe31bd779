#!/usr/bin/env python3
"""Runs of 20 s as jobs, at full speed on one core, beside the same runs by the command line.

    tests/bench/jobs_bench.py [build/release/faultlab] [--runs 600]

Then, as installed and on all cores, how late the ticks of a person's run come without and beside
10,000 such jobs.

The peer simulates and diagnoses each run in two programs, without a server, a database or a page.
"""

import argparse
import os
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "system", "members"))

from people import first_admin
from processes import Folder, Server

TICKS = os.sysconf("SC_CLK_TCK")
PEER_RUNS = 10


def cpu_s(pid):
    with open(f"/proc/{pid}/stat", encoding="utf8") as stat:
        fields = stat.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def resident_mb(pid):
    with open(f"/proc/{pid}/status", encoding="utf8") as status:
        line = next(each for each in status if each.startswith("VmRSS"))
    return int(line.split()[1]) / 1024


def run_body(i, duration_s):
    fault = {"component": "R1", "value": 10 + i % 90, "at_s": duration_s / 2}
    return {"name": f"run {i}", "duration_s": duration_s, "faults": [fault]}


def play(person, server, count, duration_s):
    """@returns (seconds to send them, seconds until the last has ended, MB in each quarter)"""
    began = time.monotonic()
    answer = person.post(server, "jobs", {"runs": [run_body(i, duration_s) for i in range(count)]})
    if answer.status != 202:
        raise RuntimeError(str(answer))
    sent = time.monotonic() - began
    at = f"jobs/batches/{answer.body['batch']}"
    resident = []
    batch = {"ended_at": None}
    while batch["ended_at"] is None:
        batch = person.get(server, f"{at}?wait=1").body
        resident.append(resident_mb(server.child.pid))
    took = time.monotonic() - began
    if batch["finished"] != count:
        raise RuntimeError(f"not all of {count} have finished: {batch}")
    began = time.monotonic()
    lines = person.get(server, f"{at}/sweep.csv").text.count("\n") - 1
    print(f"all {lines} results in one answer: {time.monotonic() - began:.2f} s")
    ends = [len(resident) * quarter // 4 for quarter in range(5)]
    return sent, took, [max(resident[a:b], default=0) for a, b in zip(ends, ends[1:])]


def practice(person, server, duration_s):
    """@returns how late the ticks of a person's run in real time came"""
    run = person.post(server, "runs", run_body(1, duration_s)).body["id"]
    state = {"state": "running"}
    while state["state"] == "running":
        state = person.get(server, f"runs/{run}?wait=20").body
    return {name: state["loop"][name] for name in ("p50_us", "p99_us", "worst_us", "overruns")}


def beside_practice(program, runs, duration_s):
    """As installed, on all cores: ticks of a person's run alone, and during a job."""
    folder = Folder()
    server = Server(
        program, folder, "bench", benches=0, simulators=8, speed=1.0,
        tables="[storage]\nsamples_per_account = 0\n",
    )
    try:
        admin = first_admin(server)
        alone = practice(admin, server, 30)
        body = {"runs": [run_body(i, duration_s) for i in range(runs)]}
        at = f"jobs/batches/{admin.post(server, 'jobs', body).body['batch']}"
        began = time.monotonic()
        beside = practice(admin, server, 30)
        done = admin.get(server, at).body
        took = time.monotonic() - began
        print(f"ticks of practice, late by: alone {alone}; during a job of {runs} runs {beside}")
        print(
            f"meanwhile {60 * done['finished'] / took:.0f} runs a minute on {os.cpu_count()} cores"
        )
        admin.delete(server, at)
    finally:
        server.kill()
        folder.remove()


def peer(program, folder, duration_s):
    """@returns seconds of each run by the command line"""
    record = folder.file("peer.csv")
    began = time.monotonic()
    for i in range(PEER_RUNS):
        fault = f"R1={10 + i % 90}@{duration_s / 2:g}"
        for command in (
            ["simulate", "--duration", f"{duration_s:g}", "--fault", fault, "-o", record],
            ["diagnose", record],
        ):
            subprocess.run([program, *command], stdout=subprocess.DEVNULL, check=False)
    return (time.monotonic() - began) / PEER_RUNS


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", nargs="?", default="build/release/faultlab")
    parser.add_argument("--runs", type=int, default=600)
    parser.add_argument("--duration", type=float, default=20.0)
    parser.add_argument("--simulators", type=int, default=8)
    parser.add_argument("--core", type=int, default=0)
    options = parser.parse_args()
    beside_practice(options.program, 10_000, options.duration)
    os.sched_setaffinity(0, {options.core})
    folder = Folder()
    server = Server(
        options.program, folder, "bench", benches=0, simulators=options.simulators, speed=1.0,
        tables="[storage]\nsamples_per_account = 0\n",
    )
    try:
        admin = first_admin(server)
        pid = server.child.pid
        play(admin, server, 20, options.duration)
        before = resident_mb(pid)
        used = cpu_s(pid)
        sent, took, quarters = play(admin, server, options.runs, options.duration)
        used = cpu_s(pid) - used
        alone = peer(options.program, folder, options.duration)
        each = took / options.runs
        print(
            f"{options.runs} runs of {options.duration:g} s on core {options.core}: {took:.1f} s, "
            f"{60 / each:.0f} a minute (goal >= 600), {used / options.runs:.4f} s of CPU each, "
            f"sent in {sent:.2f} s"
        )
        most = ", ".join(f"{each:.0f}" for each in quarters)
        print(f"resident: {before:.0f} MB before, at most {most} MB in the four quarters")
        print(f"peer, simulate and diagnose: {alone:.4f} s each; ratio {each / alone:.2f}")
    finally:
        server.kill()
        folder.remove()
    return 0


if __name__ == "__main__":
    sys.exit(main())
