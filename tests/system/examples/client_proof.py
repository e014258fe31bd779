"""deploy/examples/client.py with more values than a page of the list has jobs.

Each file that it writes must be the recording of the run with the file's value. Then the lines that faultlab.py, as the
server hands it out, shows at its top; a session on a bench.
"""

import argparse
import concurrent.futures
import os
import subprocess
import sys
import textwrap
import time
import urllib.request

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..", "..")
sys.path.insert(0, os.path.join(HERE, "..", "members"))

from lab import all_runs, stamp
from people import first_admin
from processes import Folder, Server

COMPONENT = "R1"
EXAMPLES = os.path.join(ROOT, "deploy", "examples")
BENCH = """
from faultlab import Refused
with lab.session("bench", minutes=5) as rig, lab.session("bench") as same:
    run = same.run(faults=[dict(component="R1", value=56, at_s=10)], duration_s=20)
    print("bench:", run.found()[0] if same.rig == rig.rig else "another rig")
    lab.post("sessions/" + str(rig.id) + "/end")
print("samples:", len(run.samples()))
try:
    lab.post("fault-sets", dict(name="x", faults=[]))
except Refused as refused:
    print("refused:", refused.reason)
"""


def sweep(server, key, values, duration_s, out):
    client = [sys.executable, os.path.join(EXAMPLES, "client.py")]
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


def shown_lines(url, key):
    """The program at the top of faultlab.py, for this server."""
    with open(os.path.join(EXAMPLES, "faultlab.py"), encoding="utf8") as file:
        text = file.read().split('"""')[1]
    lines = textwrap.dedent(text[text.index("    from faultlab"):text.index("\n\nA bench is")])
    return lines.replace('"http://127.0.0.1:8080"', repr(url)).replace('"flk_.."', repr(key))


def wrong_with_module(server, folder, key):
    """@returns what is wrong with faultlab.py for who has downloaded it"""
    wrong = []
    url = f"http://127.0.0.1:{server.port}"
    downloaded = folder.file("faultlab.py")
    with urllib.request.urlopen(f"{url}/faultlab.py", timeout=30) as answer:
        if not answer.headers["Content-Type"].startswith("text/x-python"):
            wrong.append(f"faultlab.py comes as {answer.headers['Content-Type']}")
        with open(downloaded, "wb") as file:
            file.write(answer.read())
    program = shown_lines(url, key) + BENCH.format(url=url, key=key)
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=os.path.dirname(downloaded),
        capture_output=True, text=True, check=False,
    )
    said = done.stdout.splitlines()
    for line, name in zip(said, ("R1", "C8", "R12", "bench: R1", "samples: 2000", "refused: scope_lacking")):
        if not line.startswith(name) or (" -> " in line and line.split(" -> ")[1].split()[0] != name):
            wrong.append(f"'{line}' for {name}")
    if done.returncode != 0 or len(said) != 6:
        wrong.append(f"the lines of faultlab.py: {done.stdout}{done.stderr[-800:]}")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--duration", type=float, default=5.0)
    options = parser.parse_args()
    folder = Folder()
    server = Server(options.program, folder, "one", benches=1, simulators=8, speed=100.0)
    failed = True
    try:
        admin = first_admin(server)
        made = admin.post(
            server, "api-keys",
            {"name": "sweep", "scopes": ["jobs", "runs:read", "runs:write", "lab"], "expires_at": stamp(time.time() + 3600)},
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
        wrong += wrong_with_module(server, folder, made.body["key"])
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
