#!/usr/bin/env python3
"""real_record.py FAULTLAB RECORD.csv[.gz] BENCH.toml STRETCH..: a record of a real motor, learnt from each stretch.

Prints for each stretch ("22:40") whether it is accepted, the alarms inside and outside of it, what is said to be visible,
and what is seen from 30 s on of faults that are added to the readings and of a dead tachometer. The record has um, ia and
n, 100 Hz; a fault is the difference of two simulated motors (um drives, the values of the calibration), so it is right
for small ones alone.
No bound is held here: print it before and after a change of core.
"""
import csv
import gzip
import json
import math
import pathlib
import subprocess
import sys
import tempfile

FAULTS = {"Ra +50 %": ("ra", 1.5), "Ke -10 %": ("ke", 0.9), "J +30 %": ("j", 1.3), "friction x 3": ("mc", 3.0)}
DEAD = ("0", "5", "500", "noise", "last")  # rpm that a dead tachometer reads
AT_S = 30.0
PERIOD_S = 0.01
STEPS = 20  # of the simulation, in a period


def simulate(um, w, ra, ke, j, mc):
    """Current (A) and speed (rad/s) at the end of each period; the motor turns at w before it."""
    out = []
    for volts in um:
        for _ in range(STEPS):
            torque = ke * (volts - ke * w) / ra
            torque -= math.copysign(mc, w) if abs(w) > 1e-3 else max(-mc, min(mc, torque))
            w += PERIOD_S / STEPS * torque / j
        out.append(((volts - ke * w) / ra, w))
    return out


def add_fault(rows, motor, name, path):
    """Writes the record with the fault's share added to ia and n."""
    um = [float(row["um_v"]) for row in rows]
    healthy = simulate(um, 0.0, **motor)
    first = round(AT_S / PERIOD_S)
    which, factor = FAULTS[name]
    faulty = simulate(um[first:], healthy[first - 1][1], **{**motor, which: factor * motor[which]})
    with open(path, "w", newline="") as file:
        out = csv.DictWriter(file, rows[0].keys())
        out.writeheader()
        for k, row in enumerate(rows):
            moved = dict(row)
            if k >= first:
                (i, w), (i0, w0) = faulty[k - first], healthy[k]
                moved["ia_a"] = repr(float(row["ia_a"]) + i - i0)
                moved["n_rpm"] = repr(float(row["n_rpm"]) + (w - w0) * 30 / math.pi)
            out.writerow(moved)


def dead_tachometer(rows, reads, path):
    """Writes the record with n as a dead tachometer reads it from AT_S on: a number, "noise" or "last"."""
    first = round(AT_S / PERIOD_S)
    with open(path, "w", newline="") as file:
        out = csv.DictWriter(file, rows[0].keys())
        out.writeheader()
        for k, row in enumerate(rows):
            read = {"noise": str(k * 7919 % 13 - 6), "last": rows[first - 1]["n_rpm"]}.get(reads, reads)
            out.writerow({**row, "n_rpm": read} if k >= first else row)


def main(binary, record, bench, *stretches):
    with (gzip.open if record.endswith("gz") else open)(record, "rt") as file:
        rows = list(csv.DictReader(file))
    folder = pathlib.Path(tempfile.mkdtemp(prefix="real-record-"))
    learnt = str(folder / "learnt.json")

    def episodes(path):
        done = subprocess.run([binary, "diagnose", path, "--bench", bench, "--calibration", learnt, "--json"],
                              capture_output=True, text=True, check=True)
        found = []
        for each in json.loads(done.stdout.splitlines()[-1]).get("episodes", []):
            named = each.get("group") or [c["component"] for c in each.get("candidates", [])[:1]]
            if "sensor" in each:
                named = ["sensor of " + each["sensor"]["channel"]]
            if "friction" in each:
                named = ["friction x {after_nm} / {before_nm}".format(**each["friction"])]
            found.append((each["detected_at_s"], f"{each['detected_at_s']:.2f} {each['verdict']} {'/'.join(named)}"))
        return found

    for stretch in stretches:
        done = subprocess.run([binary, "calibrate", record, "--bench", bench, "--healthy", stretch, "-o", learnt],
                              capture_output=True, text=True, check=False)
        if done.returncode != 0:
            print(f"{stretch}: refused: {done.stderr.strip()}")
            continue
        begin, end = (float(part) for part in stretch.split(":"))
        alarms = episodes(record)
        inside = [text for at, text in alarms if begin <= at < end]
        outside = [text for at, text in alarms if not begin <= at < end]
        print(f"{stretch}: accepted; alarms inside {inside}, outside {outside}")
        print(*(line for line in done.stdout.splitlines() if "an alarm follows" in line), sep="\n")
        with open(learnt) as file:
            known = json.load(file)
        known = known.get("calibration", known)
        value = {each["name"]: each["value"] for each in known["quantities"]}
        motor = {"ra": value["Ra"], "ke": value["Ke"], "j": value["J"], "mc": known["mc_nm"]}
        for name in FAULTS:
            changed = str(folder / "changed.csv")
            add_fault(rows, motor, name, changed)
            print(f"  {name}: {[text for at, text in episodes(changed) if at >= AT_S]}")
        for reads in DEAD:
            changed = str(folder / "changed.csv")
            dead_tachometer(rows, reads, changed)
            print(f"  n reads {reads}: {[text for at, text in episodes(changed) if at >= AT_S]}")


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
