"""Results that are kept from one run of the checks to the next: which programs passed, by their bytes.

Only of programs that no time and no chance can reach: labelled `pure`, not `system` (those read the tree), without
arguments. A key is the SHA-256 of all that such a program can see: its binary, the files of tests/data, and Debian's list
of what is installed. A changed line, flag or library is another key.
A program that left out a case is not kept. FAULTLAB_CHECK_ALL=1 runs everything.
"""

import functools
import hashlib
import os
import pathlib

import evidence

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
MOST = 2000  # lines of the list, the newest


def path():
    return pathlib.Path(evidence.folder()).parent / "passed"


def may_be(labels):
    return "pure" in labels and "system" not in labels and os.environ.get("FAULTLAB_CHECK_ALL") != "1"


@functools.cache
def surroundings():
    """The hash of what all programs see."""
    seen = hashlib.sha256()
    files = [file for file in sorted((ROOT / "tests/data").rglob("*")) if file.is_file()]
    for file in [*files, pathlib.Path("/var/lib/dpkg/status")]:
        seen.update(str(file).replace(str(ROOT), ".").encode() + b"\0" + hashlib.sha256(file.read_bytes()).digest())
    return seen.digest()


def keys(commands):
    """{name: key} of programs, given {name: [binary, arguments..]}."""
    found = {}
    for name, command in commands.items():
        if len(command) == 1 and os.path.isfile(command[0]):
            seen = hashlib.sha256(pathlib.Path(command[0]).read_bytes())
            seen.update(surroundings() + name.encode())
            found[name] = seen.hexdigest()
    return found


def known(keys_of):
    """The names among `keys_of` that passed before."""
    try:
        passed = set(path().read_text(encoding="utf-8").split())
    except FileNotFoundError:
        return set()
    return {name for name, key in keys_of.items() if key in passed}


def add(key):
    lines = path().read_text(encoding="utf-8").split() if path().exists() else []
    new = path().with_suffix(".new")
    new.write_text("\n".join([*lines, key][-MOST:]) + "\n", encoding="utf-8")
    new.replace(path())
