#!/usr/bin/env python3
"""An automated lab in 90 lines: a sweep over the values of one component, as jobs.

Needs only Python's standard library and an API key with the scopes jobs and runs:read
(page: your account > API keys, or POST /api/v1/api-keys).

    client.py --url http://localhost:8080 --key flk_... --component R1 --values 10,56,100
"""
import argparse
import json
import sys
import time
import urllib.error
import urllib.request
import uuid


class Lab:
    def __init__(self, url, key):
        self.url = url.rstrip("/") + "/api/v1/"
        self.key = key

    def call(self, method, path, body=None, headers=None):
        request = urllib.request.Request(self.url + path, method=method)
        request.add_header("Authorization", "Bearer " + self.key)
        for name, value in (headers or {}).items():
            request.add_header(name, value)
        data = None
        if body is not None:
            data = json.dumps(body).encode()
            request.add_header("Content-Type", "application/json")
        while True:
            try:
                with urllib.request.urlopen(request, data, timeout=30) as answer:
                    return answer.read()
            except urllib.error.HTTPError as error:
                problem = error.read().decode(errors="replace")
                if error.code == 503:  # the server is busy and states when to try again
                    time.sleep(float(error.headers.get("Retry-After", "1")))
                    continue
                sys.exit(f"{method} {path}: {error.code} {problem}")

    def json(self, *args, **kwargs):
        return json.loads(self.call(*args, **kwargs))

    def jobs(self, batch):
        """All jobs of a batch, as they were requested; the list comes newest first, in pages."""
        jobs, cursor = [], ""
        while cursor is not None:
            page = self.json("GET", f"jobs?batch={batch}&limit=200" + cursor)
            jobs += page["items"]
            cursor = page["next_cursor"] and f"&cursor={page['next_cursor']}"
        return jobs[::-1]


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
    runs = [
        {
            "name": f"{options.component} = {value:g}",
            "duration_s": options.duration,
            "faults": [
                {"component": options.component, "value": value, "at_s": options.duration / 2}
            ],
        }
        for value in values
    ]
    # The key makes the request safe to repeat: after a lost answer the sweep is not started twice.
    batch = lab.json("POST", "jobs", {"name": "sweep", "runs": runs},
                     {"Idempotency-Key": str(uuid.uuid4())})["batch"]
    while True:
        jobs = lab.jobs(batch)
        progress = sum(job["progress"] for job in jobs) / len(jobs)
        print(f"\r{100 * progress:3.0f} %", end="", file=sys.stderr, flush=True)
        if all(job["state"] in ("finished", "failed", "cancelled") for job in jobs):
            break
        time.sleep(0.5)
    print(file=sys.stderr)

    failed = False
    for value, job in zip(values, jobs, strict=True):
        if job["state"] != "finished":
            print(f"{value:g}\t{job['state']}\t{job['error']}")
            failed = True
            continue
        found = lab.json("GET", f"runs/{job['run']}/diagnosis")
        best = (found.get("candidates") or [{}])[0]
        print(f"{value:g}\t{found['verdict']}\t{best.get('component')}\t{best.get('value')}")
        with open(f"{options.out}/{options.component}-{value:g}.csv", "wb") as file:
            file.write(lab.call("GET", f"runs/{job['run']}/export.csv"))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
