"""Whether deploy/THIRD_PARTY.md lists what the programs are made of: the Debian source packages of every header that was
compiled into them and of every library that they are linked to, no more and no fewer.

  licences.py --build DIR --list deploy/THIRD_PARTY.md
"""

import argparse
import os
import re
import subprocess
import sys

PROGRAMS = ("faultlab", "faultlab-rig")
# Of sanitizers, which no release has.
NOT_OURS = re.compile(r"lib(asan|ubsan|tsan)\.so")


def said(*command):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False).stdout


def headers(build):
    """The headers of the system in the product's objects."""
    found, ours = set(), False
    for line in said("ninja", "-C", build, "-t", "deps").splitlines():
        if line and not line.startswith(" "):
            ours = re.match(r"(core|hardware|server)/", line) is not None
        elif ours and line.strip().startswith("/usr/"):
            found.add(os.path.realpath(line.strip()))
    return found


def libraries(build):
    """The libraries that the programs themselves name."""
    found = set()
    for program in PROGRAMS:
        path = os.path.join(build, program)
        named = re.findall(r"NEEDED.*\[(.*)\]", said("readelf", "-d", path))
        where = dict(re.findall(r"(\S+) => (/\S+)", said("ldd", path)))
        found |= {os.path.realpath(where[name]) for name in named if name in where and not NOT_OURS.match(name)}
    return found


def sources(files):
    """{Debian source package: one of its files}"""
    binaries = {}
    for line in said("dpkg", "-S", *sorted(files)).splitlines():
        packages, file = line.split(": ", 1)
        binaries.setdefault(packages.split(", ")[0], file)
    return {said("dpkg-query", "-W", "-f", "${source:Package}\n", binary).split("\n")[0]: file
            for binary, file in binaries.items()}


def listed(text):
    section = text.split("\n## The programs", 1)[1].split("\n## ", 1)[0]
    return set(re.findall(r"^\| `([^`]+)` \| [^|]*\w[^|]* \|", section, re.M))


def faults(used, rows):
    """What is wrong, as sentences."""
    return [f"{name} has no row: {file}" for name, file in sorted(used.items()) if name not in rows] + [
        f"{name} has a row, and nothing of it is used" for name in sorted(rows - set(used))]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", required=True)
    parser.add_argument("--list", required=True)
    options = parser.parse_args()
    found = headers(options.build)
    linked = libraries(options.build)
    if len(found) < 500 or len(linked) < 10:
        print(f"{len(found)} headers and {len(linked)} libraries: is {options.build} built by ninja?")
        return 1
    used = sources(found | linked)
    with open(options.list, encoding="utf-8") as file:
        rows = listed(file.read())
    # The test can fail: a row too few, a row too many.
    some = next(iter(rows))
    assert faults(used, rows - {some}) and faults(used, rows | {"left-pad"})
    wrong = faults(used, rows)
    print("\n".join(f"THIRD_PARTY.md: {each}" for each in wrong) or
          f"{len(rows)} packages of {len(found)} headers and {len(linked)} libraries have their rows")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
