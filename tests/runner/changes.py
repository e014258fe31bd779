"""Which files a change touches, for deploy/check and deploy/tidy."""

import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def lines(*command):
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()


def base():
    """main, if HEAD has something beyond it; else the commit before; None for the first commit or without git."""
    for ref in ("main", "origin/main"):
        found = subprocess.run(["git", "merge-base", "HEAD", ref], cwd=ROOT, capture_output=True, text=True, check=False)
        if found.returncode == 0 and found.stdout.strip() != lines("git", "rev-parse", "HEAD")[0]:
            return found.stdout.strip()
    before = subprocess.run(["git", "rev-parse", "-q", "--verify", "HEAD~1"], cwd=ROOT, capture_output=True, text=True, check=False)
    return before.stdout.strip() or None


def since(ref):
    """Of the work tree, too."""
    files = set(lines("git", "diff", "--name-only", ref)) | set(lines("git", "ls-files", "--others", "--exclude-standard"))
    return sorted(file for file in files if (ROOT / file).exists())
