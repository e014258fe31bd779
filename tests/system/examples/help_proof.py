"""Each example that `--help` of each command shows, run as it stands in a folder with its files.

It must end with 0, say nothing on stderr, and print something or write the file that it names. What needs another
program, or never ends, is listed here with the test that runs it.
"""

import argparse
import os
import re
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "members"))

from processes import Folder

ELSEWHERE = {  # how they begin: who runs them
    "faultlab serve": "tests/system/serve_test.cc",
    "faultlab rig": "tests/system/recovery, hardware_agent_test",
    "lcm-logger": "a program of LCM",
    "faultlab lcm import seen.lcm": "of what that has written; hardware_lcm_test",
    "faultlab plot RUN-ID": "needs a run of a server: cli_plot_test",
    "faultlab admin": "needs a database: cli_admin_test",
    "faultlab methods": "minutes: cli_methods_test",
}
READY = [  # what the examples speak of
    "simulate --fault R1=100@10 -o run.csv",
    "simulate --fault R1=100@10 -o run.csv.gz",
    "simulate --fault R1=100@10 -o a.csv",
    "simulate --fault R1=100@10 -o b.csv.gz",
    "simulate --fault R1=100@10 -o x.csv",
    "simulate -o r1.csv",
    "simulate --fault R1=10@10 -o r10.csv",
    "simulate --fault R1=56@10 -o r56.csv",
    "simulate --fault R1=100@10 -o runs/one.csv",
    "simulate --fault R1=100@10 -o records/one.csv",
    "simulate --duration 60 -o healthy.csv",
    "calibrate --healthy 0.5:60 healthy.csv -o rig.json",
]
WRITES = ("-o", "--markdown", "--plots")


def helps(program, path=()):
    """Yields the help of each command, from the first down."""
    text = subprocess.run([program, *path, "--help"], capture_output=True, text=True, check=True).stdout
    yield text
    for block in re.findall(r"^Subcommands:\n((?:  .*\n)+)", text, re.M):
        for line in block.splitlines():
            yield from helps(program, (*path, line.split()[0]))


def examples(program):
    """Each once, in the order in which they stand; what follows two spaces is said of it."""
    found = {}
    for text in helps(program):
        for block in re.findall(r"^Examples:\n((?:  .*\n?)+)", text, re.M):
            for line in block.splitlines():
                found[re.split(r"\s{2,}", line.strip())[0]] = True
    return list(found)


def wrong(command, folder, environment):
    """@returns what is wrong with an example, None if nothing is"""
    runs = command.split(" | ")[0].split(" && lcm-")[0]
    done = subprocess.run(["sh", "-c", runs], cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        return f"exit {done.returncode}: {done.stderr.strip()[-300:]}"
    if done.stderr.strip():
        return f"says on stderr: {done.stderr.strip()[-300:]}"
    words = runs.split()
    named = [words[i + 1] for i, word in enumerate(words[:-1]) if word in WRITES]
    missing = [name for name in named if not os.path.exists(os.path.join(folder, name))]
    if missing:
        return f"has not written {missing}"
    return None if named or done.stdout.strip() else "prints nothing"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    options = parser.parse_args()
    folder = Folder()
    root = folder.file("examples")
    for name in ("", "runs", "records", "bin"):
        os.makedirs(os.path.join(root, name), exist_ok=True)
    os.symlink(os.path.abspath(options.program), os.path.join(root, "bin", "faultlab"))
    environment = {**os.environ, "PATH": f"{root}/bin:{os.environ['PATH']}"}
    failed = [f"{command}: {found}" for command in READY if (found := wrong(f"faultlab {command}", root, environment))]
    ran = 0
    for command in examples(options.program):
        if any(command.startswith(begin) for begin in ELSEWHERE):
            continue
        ran += 1
        if found := wrong(command, root, environment):
            failed.append(f"{command}: {found}")
    folder.remove()
    print(*failed, sep="\n")
    print(f"{ran} examples, {len(failed)} things wrong")
    sys.exit(1 if failed or ran < 25 else 0)


if __name__ == "__main__":
    main()
