"""The database goes away in the middle of recorded runs: PostgreSQL is stopped (-m immediate), for a
minute by default, and started again. Real processes.

whole    a run goes on; every sample that its live view got is in the recording, bit for bit (as f32)
stopped  a run is stopped by its live view meanwhile; DELETE and stop by HTTP are refused and have no
         effect later; afterwards the run is stored as stopped, whole, and can be deleted
killed   the server is killed (SIGKILL) meanwhile; started again, it has every sample that the live
         view got until a second before
full     a server on SQLite, whose disk somebody else fills: the run in progress ends and says why,
         people sign in, end a session and delete; /readyz is 503, and 200 when there is space again.
         On a disk of its own (tmpfs); left out where this process may not mount
"""

import argparse
import ctypes
import json
import os
import struct
import sys
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "members"))

import lab
from people import LiveView, Person, first_admin, new_person, request
from processes import Folder, Postgres, Server, await_true

PARTS = ("whole", "stopped", "killed", "full")
COLUMNS = 23
SAMPLE_COLUMNS = ("uc_v", "um_v", "ua_v", "ia_a", "n_rpm")  # the first of a row
RATE_HZ = 100


def as_f32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


class Recording(LiveView):
    """A live view that keeps the samples and counts what it lost."""

    def __init__(self, server, person, run):
        self.samples = {}  # index -> values of SAMPLE_COLUMNS
        self.heard_at = {}
        self.texts = []
        super().__init__(server, person, run)

    def _hear(self, message):
        self.texts.append(message)
        super()._hear(message)

    def _rows(self, payload):
        _, _, count, first, _ = struct.unpack_from("<BBHId", payload)
        width = COLUMNS * 4
        now = time.monotonic()
        at = 16
        for i in range(count):
            self.samples[first + i] = struct.unpack_from(f"<{len(SAMPLE_COLUMNS)}f", payload, at + i * width)
            self.heard_at[first + i] = now

    def stop(self):
        text = json.dumps(
            {"type": "command", "epoch": self.epoch, "id": "stop", "action": "stop"}
        ).encode()
        self._send(1, text)


class World:
    def __init__(self, options):
        self.options = options
        self.folder = Folder()
        self.postgres = None
        self.away = False
        self.findings = []
        self.server = None
        if options.only != "full":
            self.postgres = Postgres(self.folder)
            self.start()
            self.admin = first_admin(self.server)

    def start(self):
        self.server = Server(
            self.options.program, self.folder, "a", self.postgres.url, benches=0, simulators=4, speed=1.0
        )

    def check(self, holds, text):
        if not holds:
            self.findings.append(text)
            print(f"BROKEN: {text}", flush=True)
        return holds

    def run(self, seconds):
        started = self.admin.post(self.server, "runs", {"duration_s": seconds})
        if started.status != 201:
            raise RuntimeError(f"no run: {started}")
        return started.body["id"]

    def database_off(self):
        self.postgres.stop()
        self.away = True

    def database_on(self):
        self.postgres.start()
        self.away = False

    def state(self, run):
        return lab.run_state(self.admin, self.server, run)

    def ready(self):
        return request(self.server.port, "GET", "/readyz").status

    def stored(self, run, first):
        """index -> values, from the API; at most 10,000 at once"""
        out = {}
        while True:
            answer = self.admin.get(self.server, f"runs/{run}/samples?from={first}&to={first + 5000}")
            if not answer.ok:
                raise RuntimeError(f"samples of {run}: {answer}")
            columns = [answer.body[name] for name in SAMPLE_COLUMNS]
            for i, index in enumerate(answer.body["index"]):
                out[index] = [column[i] for column in columns]
            if not answer.body["index"]:
                return out
            first = answer.body["index"][-1] + 1

    def compare(self, name, run, seen, until=None):
        stored = self.stored(run, 0)
        print(f"  {name}: {len(seen)} samples seen live, {len(stored)} stored", flush=True)
        whole = sorted(stored) == list(range(len(stored)))
        self.check(whole, f"{name}: the recording has a hole")
        lost = [i for i in seen if (until is None or i < until) and i not in stored]
        self.check(not lost, f"{name}: {len(lost)} samples were seen and are not stored, from {lost[:1]}")
        other = [
            i for i, values in seen.items()
            if i in stored and any(
                v is not None and as_f32(v) != s for v, s in zip(stored[i], values)
            )
        ]
        self.check(not other, f"{name}: {len(other)} samples differ, from {other[:1]}")
        compared = [i for i in seen if i in stored and stored[i][0] is not None]
        self.check(compared, f"{name}: nothing was compared")

    def end(self):
        if self.server and self.server.runs():
            self.server.kill()
        if self.postgres and not self.away:
            self.postgres.stop()
        if self.findings or self.options.keep:
            print(f"logs are in {self.folder.path}")
        else:
            self.folder.remove()


def whole(world):
    outage = world.options.outage
    run = world.run(outage + 15)
    view = Recording(world.server, world.admin, run)
    await_true("3 s of the run", lambda: len(view.samples) > 3 * RATE_HZ)
    world.check(world.ready() == 200, "whole: not ready before the outage")
    world.database_off()
    time.sleep(outage)
    world.check(world.ready() == 503, "whole: ready without a database")
    seen = len(view.samples)
    world.check(seen > 0.8 * outage * RATE_HZ, f"whole: only {seen} samples were seen in the outage")
    world.database_on()
    back = time.monotonic()
    await_true("the server is ready", lambda: world.ready() == 200, 30)
    ready_s = time.monotonic() - back
    await_true("the run ends", lambda: world.state(run) not in ("running", "(503)", "(0)"), 120, 0.2)
    print(f"  whole: ready {ready_s:.1f} s after the database, run {world.state(run)}", flush=True)
    world.check(world.state(run) == "finished", f"whole: the run is {world.state(run)}")
    world.compare("whole", run, view.samples)


def stopped(world):
    run = world.run(600)
    other = world.run(600)
    view = Recording(world.server, world.admin, run)
    await_true("3 s of the run", lambda: len(view.samples) > 3 * RATE_HZ)
    world.database_off()
    time.sleep(2)
    for what, answer in (
        ("stop", world.admin.post(world.server, f"runs/{other}/stop")),
        ("delete", world.admin.delete(world.server, f"runs/{run}")),
    ):
        world.check(answer.status == 503, f"stopped: {what} without a database: {answer}")
        world.check("faultlab" not in answer.text and "SELECT" not in answer.text, f"stopped: leaks: {answer}")
    view.stop()
    await_true("the stop is acknowledged", lambda: "stop" in view.accepted, 10)
    began = time.monotonic()
    time.sleep(world.options.outage)
    await_true("no sample after the stop", lambda: max(view.heard_at.values()) < began + 2, 10)
    world.database_on()
    await_true("the run is stored", lambda: world.state(run) not in ("running", "(503)", "(0)"), 60, 0.1)
    world.check(world.state(run) == "stopped", f"stopped: the run is {world.state(run)}")
    world.compare("stopped", run, view.samples)
    world.check(world.state(other) == "running", "stopped: a refused stop had an effect later")
    deleted = world.admin.delete(world.server, f"runs/{run}")
    world.check(deleted.status == 204, f"stopped: {deleted}")
    again = world.admin.delete(world.server, f"runs/{run}")
    world.check(again.status == 404, f"stopped: deleted twice: {again}")
    done = world.admin.post(world.server, f"runs/{other}/stop")
    world.check(done.status == 202, f"stopped: {done}")
    await_true("the other run ends", lambda: world.state(other) == "stopped", 30, 0.1)
    left = os.listdir(world.folder.file("data-a/faultlab.backlog"))
    world.check(not left, f"stopped: left on the disk: {left}")


def killed(world):
    run = world.run(600)
    view = Recording(world.server, world.admin, run)
    await_true("3 s of the run", lambda: len(view.samples) > 3 * RATE_HZ)
    world.database_off()
    # In time of the run: a machine that is busy gives neither the run nor its view their turn.
    wanted = len(view.samples) + max(3.0, world.options.outage / 2) * RATE_HZ
    await_true("the outage lasts", lambda: len(view.samples) > wanted)
    world.server.kill()
    seen = dict(view.samples)
    until = max(seen) - 1.5 * RATE_HZ
    world.database_on()
    world.start()
    await_true("the run is marked", lambda: world.state(run) == "interrupted", 60, 0.2)
    world.compare("killed", run, seen, until)
    deleted = world.admin.delete(world.server, f"runs/{run}")
    world.check(deleted.status == 204, f"killed: {deleted}")


def mount_small_disk(path, megabytes):
    """In a mount namespace of this process. @returns whether it may"""
    libc = ctypes.CDLL(None, use_errno=True)
    new_namespace, private = 0x00020000, 1 << 18 | 1 << 14
    if libc.unshare(new_namespace) != 0 or libc.mount(b"none", b"/", None, private, None) != 0:
        return False
    return libc.mount(b"tmpfs", path.encode(), b"tmpfs", 0, f"size={megabytes}m".encode()) == 0


def full(world):
    disk = world.folder.file("data-full")
    os.mkdir(disk)
    if not mount_small_disk(disk, 96):
        print("  full: left out, this process may not mount")
        return
    server = Server(
        world.options.program, world.folder, "full", benches=1, simulators=1, speed=1.0,
        settings='guests = "never"\n[storage]\ndisk_reserve_mb = 32\n',
    )
    try:
        admin = first_admin(server)
        person = new_person(server, admin, "mila")
        session = lab.session_on(person, server, "bench")
        run = person.start_run(server, session["rig"], 600)
        world.check(run.status == 201, f"full: {run}")
        run = run.body["id"]
        ready = lambda: request(server.port, "GET", "/readyz").status
        world.check(ready() == 200, "full: not ready before")
        ballast = os.path.join(disk, "somebody-elses")
        with open(ballast, "wb", buffering=0) as out:
            try:
                while True:
                    out.write(b"x" * (1 << 20))
            except OSError:
                pass
        await_true("readyz tells of the full disk", lambda: ready() == 503, 10)
        with open(ballast, "ab", buffering=0) as out:
            world.check(os.statvfs(disk).f_bavail * 4096 > 1 << 20, "full: nothing was given back")
        await_true("the run ends", lambda: lab.run_state(person, server, run) == "failed", 30, 0.1)
        answer = person.get(server, f"runs/{run}")
        print(f"  full: the run {answer.body['state']} with {answer.body['samples']} samples")
        again = Person(server.port, "mila")
        ended = again.post(server, f"sessions/{session['id']}/end")
        world.check(ended.ok, f"full: the session: {ended}")
        deleted = again.delete(server, f"runs/{run}")
        world.check(deleted.status == 204, f"full: {deleted}")
        refused = again.post(server, "runs", {"duration_s": 5})
        world.check(refused.status == 503, f"full: a new run: {refused}")
        world.check("disk_full" in refused.text, f"full: a new run: {refused}")
        os.remove(ballast)
        await_true("ready again", lambda: ready() == 200, 10)
        lab.await_rigs(admin, server, [session["rig"]], "ready")
        begun = again.post(server, "runs", {"duration_s": 2})
        world.check(begun.status == 201, f"full: afterwards: {begun}")
        await_true(
            "it finishes", lambda: lab.run_state(again, server, begun.body["id"]) == "finished", 30, 0.1
        )
    finally:
        server.kill()
        ctypes.CDLL(None).umount2(disk.encode(), 2)


def main():
    parser = argparse.ArgumentParser(prog="tests/system/outage/run", description=__doc__)
    parser.add_argument("--program", default=os.path.join(HERE, "../../../build/ci/faultlab"))
    parser.add_argument("--outage", type=float, default=60.0, help="seconds, 60 by default")
    parser.add_argument("--only", default=",".join(PARTS))
    parser.add_argument("--keep", action="store_true", help="leave the logs, whatever comes out")
    options = parser.parse_args()
    options.program = os.path.abspath(options.program)
    world = World(options)
    try:
        for part in (part for part in PARTS if part in options.only.split(",")):
            print(f"== {part}, an outage of {options.outage:.0f} s", flush=True)
            {"whole": whole, "stopped": stopped, "killed": killed, "full": full}[part](world)
    except Exception as error:
        world.check(False, f"{type(error).__name__}: {error}")
    finally:
        world.end()
    print(f"{len(world.findings)} promises broken")
    return 1 if world.findings else 0


if __name__ == "__main__":
    sys.exit(main())
