"""deploy/examples/client.py with more values than a page of the list has jobs.

Each file that it writes must be the recording of the run with the file's value.
"""

import argparse
import concurrent.futures
import os
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..", "..")
sys.path.insert(0, os.path.join(HERE, "..", "members"))

from lab import all_runs, stamp
from people import first_admin
from processes import Folder, Server

COMPONENT = "R1"


def sweep(server, key, values, duration_s, out):
    client = [sys.executable, os.path.join(ROOT, "deploy", "examples", "client.py")]
    return subprocess.run(
        [*client, "--url", f"http://127.0.0.1:{server.port}", "--key", key, "--component", COMPONENT,
         "--values", ",".join(values), "--duration", f"{duration_s:g}", "--out", out],
        capture_output=True, text=True, check=False,
    )


def wrong_files(server, admin, values, out):
    """@returns what is wrong with the files of the client"""
    runs = {run["name"]: run["id"] for run in all_runs(admin, server)}

    def check(value):
        path = os.path.join(out, f"{COMPONENT}-{value}.csv")
        name = f"{COMPONENT} = {value}"
        if not os.path.exists(path):
            return f"{path} is missing"
        if name not in runs:
            return f"no run is called '{name}'"
        recorded = admin.get(server, f"runs/{runs[name]}/export.csv").text
        with open(path, encoding="utf8", newline="") as file:
            return None if file.read() == recorded else f"{path} is not the run '{name}'"

    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        return [found for found in pool.map(check, values) if found]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--duration", type=float, default=5.0)
    options = parser.parse_args()
    folder = Folder()
    server = Server(options.program, folder, "one", benches=0, simulators=8, speed=0.0)
    failed = True
    try:
        admin = first_admin(server)
        made = admin.post(
            server, "api-keys",
            {"name": "sweep", "scopes": ["jobs", "runs:read"], "expires_at": stamp(time.time() + 3600)},
        )
        if made.status != 201:
            raise RuntimeError(str(made))
        out = folder.file("out")
        os.mkdir(out)
        values = [f"{10 + i}" for i in range(options.count)]
        done = sweep(server, made.body["key"], values, options.duration, out)
        printed = [line.split("\t")[0] for line in done.stdout.splitlines()]
        wrong = wrong_files(server, admin, values, out)
        if done.returncode != 0:
            wrong.insert(0, f"exit {done.returncode}: {done.stderr[-500:]}{done.stdout[-500:]}")
        if printed != values:
            wrong.insert(0, f"{len(printed)} lines for {len(values)} values")
        print(*wrong[:10], sep="\n")
        print(f"{len(values)} values, {len(wrong)} things wrong")
        failed = bool(wrong)
    finally:
        server.kill()
        if not failed:
            folder.remove()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
