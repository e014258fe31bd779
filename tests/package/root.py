"""A Debian root of its own for each proof: layers below one that is thrown away."""

import json
import os
import shutil
import subprocess
import time
import urllib.error
import urllib.request

HERE = os.path.dirname(os.path.abspath(__file__))
URL = "http://127.0.0.1:8080"
READY_S = 60


class Failure(Exception):
    pass


def check(true, what):
    if not true:
        raise Failure(what)


def await_true(what, probe, seconds=READY_S):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = probe()
        if found:
            return found
        time.sleep(0.1)
    raise Failure(f"not within {seconds} s: {what}")


class Root:
    """`folder`/NAME over the folders of `layers`, the first on top. Its mounts end with this process's mount namespace."""

    def __init__(self, folder, name, layers):
        own = os.path.join(folder, name)
        shutil.rmtree(own, ignore_errors=True)
        self.changes = os.path.join(own, "changes")
        self.path = os.path.join(own, "root")
        work = os.path.join(own, "work")
        for each in (self.changes, self.path, work):
            os.makedirs(each)
        lower = ":".join(layers)
        subprocess.run(
            ["mount", "-t", "overlay", "overlay", "-o",
             f"lowerdir={lower},upperdir={self.changes},workdir={work}", self.path], check=True,
        )
        for kind, where in (("proc", "proc"), ("tmpfs", "dev/shm"), ("tmpfs", "run")):
            os.makedirs(self.file(where), exist_ok=True)
            subprocess.run(["mount", "-t", kind, kind, self.file(where)], check=True)
        for device in ("null", "zero", "random", "urandom"):
            subprocess.run(["mount", "--bind", f"/dev/{device}", self.file(f"dev/{device}")], check=True)

    def with_services(self):
        """From now on packages find a running systemd: the stand-in."""
        shutil.copy(os.path.join(HERE, "systemctl"), self.file("usr/bin/systemctl"))
        os.makedirs(self.file("run/systemd/system"), exist_ok=True)
        return self

    def file(self, path):
        return os.path.join(self.path, path.lstrip("/"))

    def read(self, path):
        with open(self.file(path), encoding="utf-8") as file:
            return file.read()

    def run(self, *command, fails=False, **more):
        """@returns what the command prints, both streams"""
        done = subprocess.run(
            ["chroot", self.path, "/usr/bin/env", "-i", "PATH=/usr/sbin:/usr/bin:/sbin:/bin", "LANG=C.UTF-8",
             "DEBIAN_FRONTEND=noninteractive", *command],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True, check=False, **more,
        )
        check((done.returncode != 0) == fails, f"{' '.join(command)}: status {done.returncode}\n{done.stdout}")
        return done.stdout

    def install(self, *packages, fails=False):
        """By apt, with the dependencies that the base has downloaded."""
        for package in packages:
            shutil.copy(package, self.file("tmp"))
        names = [f"/tmp/{os.path.basename(package)}" for package in packages]
        return self.run("apt-get", "install", "-q", "-y", "--no-install-recommends", "--allow-downgrades", *names, fails=fails)

    def as_server(self, *command, fails=False):
        return self.run("runuser", "-u", "faultlab", "--", *command, fails=fails)

    def installed(self):
        return self.run("dpkg-query", "-W", "-f", "${db:Status-Abbrev} ${Package}\n")


def answer(path, key=None, body=None):
    """@returns (status, text) of the server of this network namespace; status 0: nobody listens"""
    request = urllib.request.Request(URL + path, data=None if body is None else json.dumps(body).encode())
    if body is not None:
        request.add_header("Content-Type", "application/json")
    if key is not None:
        request.add_header("Authorization", "Bearer " + key)
    try:
        with urllib.request.urlopen(request, timeout=30) as said:
            return said.status, said.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()
    except OSError:
        return 0, ""


def await_ready():
    await_true("the server is ready", lambda: answer("/readyz")[0] == 200)
