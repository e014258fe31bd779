"""deploy/examples/client.py with more values than a page of the list has jobs.

Each file that it writes must be the recording of the run with the file's value. Then the lines that faultlab.py, as the
server hands it out, shows at its top; a session on a bench; its fixture in pytest; a run's notebook.
"""

import argparse
import concurrent.futures
import json
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

PYTEST = """
from faultlab import rig

def test_the_resistor_is_found(rig):
    run = rig.run(faults=[{"component": "R1", "value": 56, "at_s": 10}], duration_s=20)
    assert run.found()[0] == "R1"
    assert PREFIX in run.data["rig"]
"""
# What a notebook runs: its cells, one after the other, in one interpreter.
CELLS = """
import json, sys
for cell in json.load(open(sys.argv[1]))["cells"]:
    if cell["cell_type"] == "code":
        exec(cell["source"], globals())
print(min(run["t_s"]), max(run["t_s"]), len(run))
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


def python_with(module):
    """The first Python here that has it."""
    for python in (sys.executable, "/usr/bin/python3"):
        if subprocess.run([python, "-c", f"import {module}"], capture_output=True, check=False).returncode == 0:
            return python
    raise RuntimeError(f"no Python here has {module}: deploy/setup --test installs it")


def wrong_with_fixture(server, folder, key):
    """@returns what is wrong with the fixture `rig` for who has downloaded faultlab.py"""
    wrong = []
    place = os.path.dirname(folder.file("faultlab.py"))
    for rig_class, prefix in ((None, "sim-"), ("bench", "bench-")):
        with open(os.path.join(place, "test_rig.py"), "w", encoding="utf8") as file:
            file.write(PYTEST.replace("PREFIX", repr(prefix)))
        said = {"FAULTLAB_URL": f"http://127.0.0.1:{server.port}", "FAULTLAB_KEY": key}
        if rig_class:
            said["FAULTLAB_RIG"] = rig_class
        done = subprocess.run(
            [python_with("pytest"), "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_rig.py"], cwd=place,
            env={**os.environ, **said}, capture_output=True, text=True, check=False,
        )
        if done.returncode != 0 or "1 passed" not in done.stdout:
            wrong.append(f"the fixture of {prefix}: {done.stdout[-800:]}{done.stderr[-400:]}")
    return wrong


def wrong_with_notebook(server, folder, key):
    """@returns what is wrong with the notebook of the newest run"""
    url = f"http://127.0.0.1:{server.port}/api/v1"

    def fetched(path):
        request = urllib.request.Request(f"{url}/{path}", headers={"Authorization": f"Bearer {key}"})
        with urllib.request.urlopen(request, timeout=30) as answer:
            return answer.read().decode("utf8")

    run = json.loads(fetched("runs?limit=1"))["items"][0]["id"]
    notebook = folder.file("run.ipynb")
    with open(notebook, "w", encoding="utf8") as file:
        file.write(fetched(f"runs/{run}/export.ipynb"))
    done = subprocess.run(
        [sys.executable, "-c", CELLS, notebook], env={**os.environ, "MPLBACKEND": "Agg"},
        capture_output=True, text=True, check=False,
    )
    lines = [line for line in fetched(f"runs/{run}/export.csv").splitlines() if line and not line.startswith("#")]
    first, last = lines[1].split(","), lines[-1].split(",")
    expected = f"{float(first[0])} {float(last[0])} {len(first)}"
    told = f"{len(lines) - 1} samples: {lines[0].replace(',', ', ')}"
    said = done.stdout.splitlines()
    if done.returncode != 0 or told not in said or said[-1] != expected:
        return [f"the notebook: {done.stdout}{done.stderr[-800:]}, not '{told}' and '{expected}'"]
    return []


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
        for look in (wrong_with_module, wrong_with_fixture, wrong_with_notebook):
            wrong += look(server, folder, made.body["key"])
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
