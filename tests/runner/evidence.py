"""What a run of the checks leaves behind: a folder outside the checkout, and the lines that end its output.

In the folder, one line a finding in `findings.tsv`: kind, part, name, first lines of the message.
    FAILED   failed, and failed again each time it was repeated
    FLAKY    failed, then passed when it was repeated alone
    SKIPPED  was not run, so that something is not tested
"""

import os
import re
import sys
import xml.etree.ElementTree as ElementTree

KINDS = ("FAILED", "FLAKY", "SKIPPED")
REPETITIONS = 2
FLAKY_MAX = 5


def folder():
    path = os.environ["FAULTLAB_CHECK_RUN"]
    os.makedirs(path, exist_ok=True)
    return path


def file(name):
    return os.path.join(folder(), name)


def note(kind, part, name, message=""):
    lines = [line.strip() for line in message.splitlines() if line.strip()]
    with open(file("findings.tsv"), "a", encoding="utf-8") as out:
        out.write("\t".join([kind, part, name, " | ".join(lines[:6])[:600].replace("\t", " ")]) + "\n")


def findings():
    try:
        with open(file("findings.tsv"), encoding="utf-8") as lines:
            return [line.rstrip("\n").split("\t") for line in lines]
    except FileNotFoundError:
        return []


def read(junit):
    """The test cases of a JUnit file; [] if the runner wrote none."""
    try:
        with open(junit, encoding="utf-8", errors="replace") as text:
            # the colours of a terminal are no XML
            return list(ElementTree.fromstring(re.sub("[\x00-\x08\x0b\x0c\x0e-\x1f]", "", text.read())).iter("testcase"))
    except (OSError, ElementTree.ParseError):
        return []


def cases(junit):
    """{name: message of its failure or None}."""
    found = {}
    for case in read(junit):
        failure = case.find("failure")
        if failure is None:
            found[case.get("name")] = None
            continue
        output = (case.findtext("system-out") or "").strip()
        found[case.get("name")] = output or failure.get("message") or failure.text or "failed"
    return found


def said(output):
    """What the failed assertions of a program say, or the end of its output."""
    lines = output.splitlines()
    found = []
    for at, line in enumerate(lines):
        if re.search(r": Failure$|ERROR: |runtime error: ", line):
            found += lines[at : at + 5]
    return "\n".join(found or lines[-6:])


def report():
    """Prints the findings; returns the exit status that they ask for."""
    found = findings()
    for kind in KINDS:
        for each, part, name, message in found:
            if each == kind:
                print(f"{kind} {part}: {name}" + (f"\n    {message}" if message else ""))
    count = {kind: sum(each[0] == kind for each in found) for kind in KINDS}
    if count["FLAKY"] > FLAKY_MAX:
        print(f"FAILED: {count['FLAKY']} flaky tests are more than {FLAKY_MAX}")
    lost = count["SKIPPED"] if os.environ.get("CI") == "true" else 0
    if lost:
        print("FAILED: with CI=true nothing may be skipped")
    return 1 if count["FAILED"] or lost or count["FLAKY"] > FLAKY_MAX else 0


if __name__ == "__main__":
    if sys.argv[1] == "note":
        note(*sys.argv[2:])
    else:
        sys.exit(report())
