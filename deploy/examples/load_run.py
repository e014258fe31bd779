#!/usr/bin/env python3
"""Reads what a run's page downloads, with numpy alone.

    load_run.py SAMPLES.csv [ESTIMATES.csv]     prints what is in them

    import load_run
    run = load_run.read_csv("2026-11-21_0102_R1_samples.csv")
    run["t_s"], run["um_v"]              float arrays, a lost reading is nan
    found = load_run.read_csv("2026-11-21_0102_R1_estimates.csv")
    found["sia_100_20_b0"], found["sia_100_20_status"]

The MAT file needs scipy.io.loadmat, the JSON file json.load.
"""

import csv
import gzip
import sys

import numpy as np


def read_csv(path):
    """The columns of a CSV by name: float arrays; those named .._status are texts.

    Lines that begin with # are under "comments".
    """
    opener = gzip.open if str(path).endswith(".gz") else open
    comments, rows = [], []
    with opener(path, "rt", encoding="utf-8", newline="") as file:
        for line in file:
            if line.startswith("#"):
                comments.append(line[1:].strip())
            elif line.strip():
                rows.append(line)
    table = list(csv.reader(rows))
    names, cells = table[0], table[1:]
    columns = {"comments": comments}
    for at, name in enumerate(names):
        column = [row[at] for row in cells]
        if name.endswith("_status"):
            columns[name] = np.array(column)
        else:
            columns[name] = np.array([float(cell) if cell else np.nan for cell in column])
    return columns


def main(paths):
    for path in paths:
        columns = read_csv(path)
        for comment in columns.pop("comments"):
            print("#", comment[:100])
        for name, column in columns.items():
            if column.dtype.kind == "U":
                words, counts = np.unique(column, return_counts=True)
                print(f"{name:24}", ", ".join(f"{w} {c}" for w, c in zip(words, counts)))
            elif np.isfinite(column).any():
                low, mean, high = np.nanmin(column), np.nanmean(column), np.nanmax(column)
                print(f"{name:24} {len(column)} values, {low:.6g} .. {high:.6g}, mean {mean:.6g}")
            else:
                print(f"{name:24} {len(column)} values, none known")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(sys.argv[1:])
