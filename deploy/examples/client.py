#!/usr/bin/env python3
"""An automated lab: a sweep over the values of one component, as jobs, by faultlab.py beside this file.

Needs only Python's standard library and an API key with the scopes jobs and runs:read
(page: your account > API keys, or POST /api/v1/api-keys).

    client.py --url http://localhost:8080 --key flk_... --component R1 --values 10,56,100
"""
import argparse
import sys

from faultlab import Lab, Run


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--url", default="http://localhost:8080")
    parser.add_argument("--key", required=True)
    parser.add_argument("--component", default="R1")
    parser.add_argument("--values", default="10,56,100", help="in the component's SI unit")
    parser.add_argument("--duration", type=float, default=20.0, help="seconds of each run")
    parser.add_argument("--out", default=".", help="folder for the CSV files")
    options = parser.parse_args()
    lab = Lab(options.url, options.key)

    values = [float(text) for text in options.values.split(",")]
    at_s = options.duration / 2
    batch = lab.jobs(
        (
            {
                "name": f"{options.component} = {value:g}",
                "duration_s": options.duration,
                "faults": [{"component": options.component, "value": value, "at_s": at_s}],
            }
            for value in values
        ),
        name="sweep",
    )
    failed = False
    for value, job in zip(values, batch.wait().results(), strict=True):
        if job["state"] != "finished":
            print(f"{value:g}\t{job['state']}\t{job['error']}")
            failed = True
            continue
        run = Run(lab, job["run"])
        component, found, _ = run.found()
        print(f"{value:g}\t{run.diagnosis()['verdict']}\t{component}\t{found}")
        with open(f"{options.out}/{options.component}-{value:g}.csv", "wb") as file:
            file.write(run.csv())
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
