#!/usr/bin/env python3
"""mutants.py [BUILD [NAME .. | --every N]]: breaks one rule after the other and demands that a test finds each.

Each ROOM/*.patch beside this file changes one source file of the product. Its first line says who must catch it:
  caught by: RULE                 a rule of the rehearsal's oracle (tests/world), whatever the seed
  tested by: PROGRAM FILTER       tests of a program of GoogleTest
The patch is applied to a copy, that file alone is compiled (without sanitizers) and linked before the libraries of the
build folder BUILD, and the judge runs. A patch that does not apply, does not compile or is not caught fails. Without
BUILD: whether all apply.
"""
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
STEPS = 10_000
JUDGE = "lab_rehearsal_judge"
SEEDS = (2, 1, 3, 4, 5, 6)  # of so many steps each, until one catches it
LONGEST_S = 120


class NotCaught(Exception):
    pass


def run(command, **more):
    done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST_S, **more)
    if done.returncode != 0:
        raise NotCaught(f"{command[0]} failed: {(done.stdout + done.stderr)[-1500:]}")
    return done.stdout


def compiles(entry, source):
    """Whether this command of the build compiles the source, alone or within a file that includes it."""
    file = pathlib.Path(entry["directory"], entry["file"]).resolve()
    return file == (ROOT / source).resolve() or (
        "_unity_" in file.name and f'#include "{source}"' in file.read_text().splitlines()
    )


def compile_command(build, source, to, output):
    """The build's own command for this file, without ccache, sanitizers and dependency files."""
    for entry in json.loads((build / "compile_commands.json").read_text()):
        if compiles(entry, source):
            words = shlex.split(entry["command"])
            break
    else:
        raise NotCaught(f"the build has no command for {source}")
    words = words[next(i for i, word in enumerate(words) if re.search(r"(^|/)(c|g|clang)\+\+", word)):]
    words = [word for word in words if not word.startswith(("-fsanitize", "-O", "-W", "-g"))]
    for flag in ("-o", "-MF", "-MT", "-include"):
        if flag in words:
            at = words.index(flag)
            del words[at : at + 2]
    words = [word for word in words if word not in ("-MD", "-fpch-preprocess", entry["file"])]
    return [*words, "-O1", str(to), "-o", str(output)]


def link_command(build, target, mutant, output):
    """The link of the target, with the changed object before everything else."""
    commands = run(["ninja", "-C", str(build), "-t", "commands", target]).splitlines()
    words = [word for word in shlex.split(commands[-1].replace("&&", "")) if word != ":"]
    words = words[next(i for i, word in enumerate(words) if re.search(r"(^|/)(c|g|clang)\+\+", word)):]
    at = words.index("-o")
    words[at + 1] = str(output)
    first = next(i for i, word in enumerate(words) if word.endswith(".o"))
    words.insert(first, str(mutant))
    # The first definition counts: a library's object may hold other sources besides the changed one.
    return [*words, "-Wl,--allow-multiple-definition"]


def change(patch, folder):
    """Applies the patch to a copy in the folder.

    @returns the source file's path in the tree
    """
    lines = patch.read_text().splitlines()
    source = next(line for line in lines if line.startswith("+++ b/")).removeprefix("+++ b/").split("\t")[0]
    changed = pathlib.Path(folder, source)
    changed.parent.mkdir(parents=True)
    changed.write_text((ROOT / source).read_text())
    run(["patch", "-p1", "--fuzz=0", "-s", "-i", str(patch)], cwd=folder)
    return source


def judge(patch, build):
    """@returns the finding that catches this mutant"""
    who, _, what = patch.read_text().splitlines()[0].partition(": ")
    target = {"caught by": JUDGE, "tested by": what.split(" ")[0]}[who]
    with tempfile.TemporaryDirectory() as folder:
        source = change(patch, folder)
        changed = pathlib.Path(folder, source)
        mutant, program = pathlib.Path(folder, "mutant.o"), pathlib.Path(folder, target)
        run(compile_command(build, source, changed, mutant), cwd=build)
        run(link_command(build, target, mutant, program), cwd=build)
        return rehearsed(program, what) if who == "caught by" else tested(program, what.split(" ")[1])


def rehearsed(judge, rule):
    others = set()
    for seed in SEEDS:
        found = subprocess.run([judge, str(STEPS), str(seed), rule], capture_output=True, text=True, timeout=LONGEST_S)
        if found.returncode not in (0, 1):
            raise NotCaught(f"it crashed: {found.stderr[-500:]}")
        for line in found.stdout.splitlines():
            broken, _, first = line.split("\t")
            if broken == rule:
                return first
            others.add(broken)
    raise NotCaught(f"expected: {rule}; broken: {', '.join(sorted(others)) or 'nothing'}")


def tested(program, which):
    found = subprocess.run([program, f"--gtest_filter={which}"], capture_output=True, text=True, timeout=LONGEST_S)
    failed = re.findall(r"^\[  FAILED  \] ([^\s,]+)(?: \(|, where)", found.stdout, re.MULTILINE)
    ran = re.search(r"Running ([1-9]\d*) test", found.stdout)
    if not ran:
        raise NotCaught(f"{which} is no test: {found.stdout[-300:]}{found.stderr[-300:]}")
    if not failed:
        raise NotCaught(f"{which} passed, or crashed with {found.returncode}: {found.stderr[-300:]}")
    return failed[0]


def main():
    names = sys.argv[2:]
    every = int(names.pop()) if names[:1] == ["--every"] else 1
    patches = [patch for patch in sorted(HERE.glob("*/*.patch")) if every > 1 or not names or patch.stem in names]
    for patch in patches:  # those, too, that are not in the sample
        with tempfile.TemporaryDirectory() as folder:
            try:
                change(patch, folder)
            except NotCaught as problem:
                sys.exit(f"{patch.name} does not apply: {problem}")
    if len(sys.argv) < 2:
        return
    build = pathlib.Path(sys.argv[1]).resolve()
    patches = patches[::every]
    unchanged = subprocess.run(
        [build / "tests/mutants" / JUDGE, str(STEPS), str(SEEDS[0])], capture_output=True, text=True
    )
    if unchanged.returncode != 0:
        sys.exit(f"without any patch: {unchanged.stdout}{unchanged.stderr}")
    failed = 0

    def one(patch):
        start = time.monotonic()
        try:
            return patch.stem, judge(patch, build), None, time.monotonic() - start
        except Exception as problem:  # any reason is a failure of this mutant, not of the others
            return patch.stem, None, problem, time.monotonic() - start

    with ThreadPoolExecutor(2) as pool:
        for name, finding, problem, took_s in pool.map(one, patches):
            failed += problem is not None
            print(f"NOT CAUGHT {name}: {problem}" if problem else f"caught {name} in {took_s:.0f} s: {finding}", flush=True)
    print(f"{len(patches) - failed} of {len(patches)} mutants caught")
    sys.exit(1 if failed or not patches else 0)


main()
