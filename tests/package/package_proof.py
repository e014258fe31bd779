#!/usr/bin/env python3
"""The Debian packages in roots of their own: see README.md in this folder.

  package_proof.py --cache FOLDER --server DEB --next DEB --agent DEB [--only install,..]
"""

import argparse
import glob
import json
import os
import re
import shutil
import sqlite3
import subprocess
import sys
import time

from root import Failure, Root, answer, await_ready, await_true, check

DATA = "/var/lib/faultlab"
BACKUPS = "/var/backups/faultlab"
CONFIG = "/etc/faultlab/config.toml"
# Needs nothing of the server's.
SERVER_LIBRARIES = ("opencv", "soci", "libpq5", "libcurl", "boost", "cairo", "sqlite", "spdlog", "freetype")


def mirror():
    """(address, suite) that apt of this machine uses"""
    with open("/etc/os-release", encoding="utf-8") as file:
        suite = re.search(r"VERSION_CODENAME=(\w+)", file.read()).group(1)
    said = subprocess.run(["apt-get", "indextargets", "--format", "$(REPO_URI)", "Created-By: Packages", f"Codename: {suite}"],
                          stdout=subprocess.PIPE, text=True, check=True)
    return said.stdout.split("\n")[0] or "http://deb.debian.org/debian", suite


def make_base(options):
    """A bare Debian with the downloaded, not installed, dependencies of the packages."""
    base = os.path.join(options.cache, "base")
    wanted = "".join(
        subprocess.run(["dpkg-deb", "-f", deb, "Depends"], stdout=subprocess.PIPE, text=True, check=True).stdout
        for deb in (options.server, options.agent))
    made = os.path.join(options.cache, "base.made")
    if os.path.exists(made) and open(made, encoding="utf-8").read() == wanted:
        return base
    shutil.rmtree(base, ignore_errors=True)
    address, suite = mirror()
    print(f"making a bare {suite} root", flush=True)
    with open(os.path.join(options.cache, "base.log"), "w", encoding="utf-8") as log:
        subprocess.run(["debootstrap", "--variant=minbase", suite, base, address], stdout=log, stderr=log, check=True)
    os.chmod(base, 0o755)
    for name in ("resolv.conf", "hosts"):
        shutil.copy(f"/etc/{name}", os.path.join(base, "etc", name))
    if os.path.exists("/etc/apt/sources.list.d/debian.sources"):
        shutil.copy("/etc/apt/sources.list.d/debian.sources", os.path.join(base, "etc/apt/sources.list.d"))
        open(os.path.join(base, "etc/apt/sources.list"), "w", encoding="utf-8").close()
    for name in glob.glob("/etc/apt/apt.conf.d/*"):
        with open(name, encoding="utf-8") as file:
            text = file.read()
        if re.search(r"^ *Acquire::", text, re.M) and not re.search("password|login|netrc", text, re.I):
            shutil.copy(name, os.path.join(base, "etc/apt/apt.conf.d"))
    with open(os.path.join(base, "etc/dpkg/dpkg.cfg.d/quick"), "w", encoding="utf-8") as file:
        file.write("force-unsafe-io\n")
    with open(os.path.join(base, "etc/apt/apt.conf.d/zz-keep"), "w", encoding="utf-8") as file:
        file.write('Binary::apt::APT::Keep-Downloaded-Packages "true";\nAPT::Keep-Downloaded-Packages "true";\nDPkg::Post-Invoke {};\n')
    root = Root(options.cache, "downloads", [base])
    root.run("apt-get", "update", "-q")
    for deb in (options.server, options.agent):
        shutil.copy(deb, root.file("tmp"))
    root.run("apt-get", "install", "-q", "-y", "--no-install-recommends", "--download-only",
             *(f"/tmp/{os.path.basename(deb)}" for deb in (options.server, options.agent)))
    # What it changed becomes a part of the base.
    for part in ("var/lib/apt/lists", "var/cache/apt/archives"):
        shutil.copytree(root.file(part), os.path.join(base, part + ".new"))
        shutil.rmtree(os.path.join(base, part))
        os.rename(os.path.join(base, part + ".new"), os.path.join(base, part))
    with open(made, "w", encoding="utf-8") as file:
        file.write(wanted)
    return base


def schema(file):
    """(newest step, whether it has the step of faultlab_next) of a database"""
    with sqlite3.connect(f"file:{file}?mode=ro", uri=True) as database:
        version, = database.execute("SELECT MAX(version) FROM schema_version").fetchone()
        columns = [row[1] for row in database.execute("PRAGMA table_info(account)")]
    return version, "of_next_version" in columns


class Lab:
    """The installed server with a student, her key and her runs."""

    def __init__(self, root):
        self.root = root
        root.as_server("faultlab", "admin", "users", "add", "ana", "--name", "Ana Petrović", "--data", DATA)
        said = root.as_server("faultlab", "admin", "keys", "add", "ana", "--scope", "jobs", "--scope", "runs:read", "--data", DATA)
        self.key = re.search(r"\bfl[a-z]*_[A-Za-z0-9_-]+", said).group(0)

    def run(self, value):
        """A run with R1 = value, by the installed example."""
        client = self.root.file("/usr/share/doc/faultlab/examples/client.py")
        subprocess.run(
            [sys.executable, "-B", client, "--url", "http://127.0.0.1:8080", "--key", self.key, "--values", str(value),
             "--out", self.root.file("tmp")], check=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=300,
        )

    def all(self):
        """Everything of every run as the server says it: {id: (about, diagnosis, samples)}."""
        status, text = answer("/api/v1/runs", self.key)
        check(status == 200, f"runs: {status} {text}")
        return {
            run["id"]: tuple(answer(f"/api/v1/runs/{run['id']}{part}", self.key) for part in ("", "/diagnosis", "/export.csv"))
            for run in json.loads(text)["items"]
        }

    def seen(self):
        return Seen(self.all())


class Seen(dict):
    """What was seen of all runs; all parts of each were answered."""

    def __init__(self, runs):
        super().__init__(runs)
        for run, parts in runs.items():
            check([status for status, _ in parts] == [200, 200, 200], f"{run}: {parts}")


def started(root):
    """The installed server, 20 times as fast as real time."""
    text = root.read(CONFIG)
    check("speed = 1.0" in text, f"{CONFIG} has no speed")
    with open(root.file(CONFIG), "w", encoding="utf-8") as file:
        file.write(text.replace("speed = 1.0", "speed = 20.0"))
    root.run("systemctl", "start", "faultlab.service")
    await_ready()
    return Lab(root)


def backups(root):
    return sorted(os.listdir(root.file(BACKUPS)))


# ---- the proofs; each has a root and a network of its own ----

def install(options, root):
    """The server's package on a bare Debian: its dependencies suffice, it serves, remove and purge keep the data."""
    root.with_services()
    root.install(options.server)
    await_ready()
    check(root.run("id", "-un", "faultlab").strip() == "faultlab", "no user")
    for folder in (DATA, BACKUPS):
        check(root.run("stat", "-c", "%U %a", folder) == "faultlab 700\n", f"{folder} is not private")
    check(root.run("systemctl", "is-enabled", "faultlab.service") == "enabled\n", "the unit is not enabled")
    check("<!doctype html>" in answer("/")[1].lower(), "no page")
    for name in ("LICENSE", "copyright", "deploy/THIRD_PARTY.md", "examples/config.example.toml"):
        check(root.read(f"/usr/share/doc/faultlab/{name}"), f"no {name}")
    missing = [line for line in root.run("ldd", "/usr/bin/faultlab").splitlines() if "not found" in line]
    check(not missing, f"libraries are missing: {missing}")
    root.as_server("faultlab", "simulate", "--bench", "/usr/share/faultlab/benches/servo-motor.toml", "-o", "/tmp/run.csv")
    root.run("systemctl", "stop", "faultlab.service")


def removed(options, root):
    """Remove and purge: the program goes, what people have made stays."""
    lab = started(root.with_services())
    lab.run(100)
    root.run("apt-get", "remove", "-q", "-y", "faultlab")
    check(answer("/readyz")[0] == 0, "it serves although it is removed")
    check(len(backups(root)) == 1, f"no backup before it was removed: {backups(root)}")
    root.run("apt-get", "purge", "-q", "-y", "faultlab")
    check(not os.path.exists(root.file("/usr/bin/faultlab")), "the program is there")
    check(not os.path.exists(root.file(CONFIG)), "the settings are there")
    check(os.path.getsize(root.file(f"{DATA}/faultlab.db")) > 0, "the data is gone")


def agent(options, root):
    """The agent's package alone: nothing of the server's, a self-test, no start without settings."""
    root.with_services()
    root.install(options.agent)
    names = root.installed()
    of_server = [each for each in SERVER_LIBRARIES if each in names]
    check(not of_server, f"the agent pulls in {of_server}")
    said = root.as_server("faultlab-rig", "--self-test")
    check("all positions answer" in said, said)
    check("start faultlab-rig.service" in root.read("/run/systemctl.log"), "it was not started")
    check(not os.path.exists(root.file("/run/faultlab-rig.service.pid")), "it runs without settings")


def upgrade(options, root):
    """The next version: saved, then migrated, and everything is there."""
    lab = started(root.with_services())
    lab.run(100)
    lab.run(33)
    before = lab.seen()
    check(len(before) == 2, f"{len(before)} runs")
    first, _ = schema(root.file(f"{DATA}/faultlab.db"))
    said = root.install(options.next)
    await_ready()
    check(lab.seen() == before, "the runs are not the same after the upgrade")
    newest, has_next = schema(root.file(f"{DATA}/faultlab.db"))
    check((newest, has_next) == (first + 1, True), f"not migrated: {first} {newest} {has_next}")
    check("speed = 20.0" in root.read(CONFIG), "the settings are not those of before")
    saved = backups(root)
    check(len(saved) == 1 and f"{BACKUPS}/{saved[0]}" in said, f"no backup, or not named: {saved}\n{said}")
    check(schema(root.file(f"{BACKUPS}/{saved[0]}")) == (first, False), "the backup is of the new version")
    check(root.run("stat", "-c", "%U %a", f"{BACKUPS}/{saved[0]}") == "faultlab 600\n", "the backup is not private")
    lab.run(56)
    check(len(lab.seen()) == 3, "no run after the upgrade")


def rollback(options, root):
    """Back to the version before, with the backup that the upgrade made."""
    lab = started(root.with_services())
    lab.run(100)
    before = lab.seen()
    first, _ = schema(root.file(f"{DATA}/faultlab.db"))
    root.install(options.next)
    await_ready()
    saved = backups(root)[0]
    lab.run(56)
    log = "/var/log/faultlab.service.log"
    seen = len(root.read(log))
    root.install(options.server)
    await_true("the old server refuses the new database", lambda: "start a newer faultlab" in root.read(log)[seen:])
    check(answer("/readyz")[0] == 0, "the old server serves the new database")
    root.run("faultlab-restore", f"{BACKUPS}/{saved}")
    await_ready()
    check(lab.seen() == before, "not the runs of before the upgrade")
    check(schema(root.file(f"{DATA}/faultlab.db")) == (first, False), "not the old schema")
    replaced = glob.glob(root.file(f"{DATA}/replaced-*/faultlab.db"))
    check(len(replaced) == 1 and schema(replaced[0]) == (first + 1, True), f"the newer database is not kept: {replaced}")
    lab.run(33)
    check(len(lab.seen()) == 2, "no run after the rollback")


def not_saved(options, root):
    """A full disk for backups: no upgrade, the old server goes on."""
    lab = started(root.with_services())
    lab.run(100)
    before = lab.seen()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "full", root.file(BACKUPS)], check=True)
    said = root.install(options.next, fails=True)
    check("not upgraded: the database could not be saved" in said, said)
    check(backups(root) == [], f"half a backup: {backups(root)}")
    await_ready()
    check(lab.seen() == before, "the runs are not the same")
    check(not schema(root.file(f"{DATA}/faultlab.db"))[1], "migrated without a backup")


def restore(options, root):
    """The drill: a backup of the working server, the data destroyed, restored, checked, served."""
    lab = started(root.with_services())
    lab.run(100)
    before = lab.seen()
    saved = "/var/backups/faultlab/drill.db"
    root.as_server("faultlab", "admin", "backup", saved, "--data", DATA)
    lab.run(56)
    root.run("systemctl", "stop", "faultlab.service")
    for name in os.listdir(root.file(DATA)):
        path = root.file(f"{DATA}/{name}")
        shutil.rmtree(path) if os.path.isdir(path) else os.remove(path)
    root.as_server("faultlab", "admin", "restore", saved, "--data", DATA)
    root.as_server("faultlab", "admin", "check", "--data", DATA)
    root.run("systemctl", "start", "faultlab.service")
    await_ready()
    check(lab.seen() == before, "not the data of the backup")
    # A damaged backup replaces nothing.
    with open(root.file(saved), "r+b") as file:
        file.seek(os.path.getsize(root.file(saved)) // 2)
        file.write(b"\xa5" * 4096)
    said = root.run("faultlab-restore", saved, fails=True)
    check("nothing is changed" in said, said)
    await_ready()
    check(lab.seen() == before, "a damaged backup has changed the data")


PROOFS = (install, agent, upgrade, rollback, not_saved, restore, removed)


def one(options):
    """In namespaces of its own: one proof."""
    proof = {each.__name__: each for each in PROOFS}[options.one]
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
    layers = [os.path.join(options.cache, "base")]
    if proof not in (install, agent):
        layers.insert(0, os.path.join(options.cache, "install", "changes"))
    root = Root(options.cache, options.one, layers)
    try:
        proof(options, root)
    except Exception:
        log = root.file("/var/log/faultlab.service.log")
        if os.path.exists(log):
            sys.stderr.write(root.read("/var/log/faultlab.service.log")[-3000:])
        raise


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("--cache", "--server", "--next", "--agent"):
        parser.add_argument(name, required=True, type=os.path.abspath)
    parser.add_argument("--only", default="")
    parser.add_argument("--one", default="")
    options = parser.parse_args()
    if options.one == "base":
        make_base(options)
        return 0
    if options.one:
        try:
            one(options)
        except Failure as failure:
            print(failure, file=sys.stderr)
            return 1
        return 0
    os.makedirs(options.cache, exist_ok=True)
    # The shell is the first process there, which collects those whose parents have ended.
    again = ["bash", "-c", '"$@"; exit $?', "bash", sys.executable, "-B", os.path.abspath(__file__), *sys.argv[1:], "--one"]
    apart = ["unshare", "--mount", "--propagation", "private", "--pid", "--fork", "--kill-child", "--ipc"]
    subprocess.run([*apart, *again, "base"], check=True)
    names = options.only.split(",") if options.only else [each.__name__ for each in PROOFS]
    failed = []
    for name in names:
        begin = time.monotonic()
        status = subprocess.run([*apart, "--net", *again, name], check=False).returncode
        print(f"{name}: {'passed' if status == 0 else 'FAILED'} in {time.monotonic() - begin:.0f} s", flush=True)
        if status != 0:
            failed.append(name)
            if name == "install":
                break
        if name != "install":
            shutil.rmtree(os.path.join(options.cache, name), ignore_errors=True)
    print(f"FAILED: {', '.join(failed)}" if failed else "all proofs of the packages passed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
