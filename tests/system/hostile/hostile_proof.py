"""A live run, and somebody else who reads, while a server is attacked from all sides."""

import argparse
import http.client
import json
import os
import subprocess
import sys
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "members"))

from attacks import ROWS, all_attacks, recording  # noqa: E402
from lab_day import Student  # noqa: E402
from lab import await_rigs, session_on  # noqa: E402
from people import PASSWORD, Person, request  # noqa: E402
from processes import Folder, Server, await_true  # noqa: E402

ENEMY = "203.0.113.66"
MEMORY_GOAL_MB = 400
WAIT_GOAL_S = 0.5  # of another user, 99 of 100 requests
P99_GOAL_S = 0.2


class World:
    """What the attacks know: a server, and what a stranger may do at it."""

    def __init__(self, server):
        self.server = server
        self.port = server.port
        self.enemy = ENEMY
        self.recording = ""
        self.run = ""

    def enemy_call(self, method, path, body=None):
        return request(self.port, method, "/api/v1/" + path, body, {"X-Forwarded-For": self.enemy}, 30)

    def enemy_run(self):
        return self.run or self.recording


def memory_mb(pid):
    with open(f"/proc/{pid}/status", encoding="ascii") as lines:
        return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS")) / 1024


def count_of(pid, what):
    return len(os.listdir(f"/proc/{pid}/{what}"))


class Reader(threading.Thread):
    """Another user, who asks who they are ten times a second on one kept connection."""

    def __init__(self, world, person):
        super().__init__(daemon=True)
        self.world = world
        self.person = person
        self.seconds = []
        self.failed = []
        self.over = threading.Event()

    def run(self):
        connection = http.client.HTTPConnection("127.0.0.1", self.world.port, timeout=60)
        while not self.over.is_set():
            began = time.monotonic()
            try:
                headers = {**self.person.headers, "X-Forwarded-For": "198.51.100.7"}
                connection.request("GET", "/api/v1/auth/me", headers=headers)
                answer = connection.getresponse()
                answer.read()
                if answer.status != 200:
                    self.failed.append(answer.status)
            except (OSError, http.client.HTTPException) as error:
                self.failed.append(repr(error))
                connection.close()
            self.seconds.append(time.monotonic() - began)
            self.over.wait(0.1)

    def quantile(self, share):
        ordered = sorted(self.seconds)
        return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def make_account(program, server, folder, login, role):
    """By `faultlab admin`, beside the running server; the one-time link sets the password."""
    made = subprocess.run(
        [program, "admin", "users", "add", login, "--role", role, "--data", folder],
        check=True,
        capture_output=True,
        text=True,
    )
    secret = next(word for word in made.stdout.split() if word.startswith("fll_"))
    answer = request(server.port, "POST", "/api/v1/auth/reset", {"token": secret, "password": PASSWORD})
    if not answer.ok:
        raise RuntimeError(f"{login}: {answer}")
    return Person(server.port, login)


def upload(world):
    connection = http.client.HTTPConnection("127.0.0.1", world.port, timeout=120)
    connection.request(
        "POST",
        "/api/v1/recordings?name=enemy",
        recording(),
        {"Content-Type": "text/csv", "X-Forwarded-For": world.enemy},
    )
    answer = json.loads(connection.getresponse().read())
    if "id" not in answer:
        raise RuntimeError(f"upload: {answer}")
    world.recording = answer["id"]


def live_run(student, server, rig, seconds):
    """@returns id of the run"""
    answer = student.post(server, "runs", {"rig": rig, "duration_s": seconds})
    if not answer.ok:
        raise RuntimeError(f"a student with a session cannot start a run: {answer}")
    return answer.body["id"]


def round_of_attacks(world, student, reader_person, students, rig, seconds, memory_scale):
    """One live run of `seconds` under all attacks. @returns (findings, figures)"""
    findings = []
    idle_mb = memory_mb(world.server.child.pid)
    attacks = all_attacks(world)
    reader = Reader(world, reader_person)
    reader.start()
    day = [Student(world.server, login, f"198.51.100.{20 + i}") for i, login in enumerate(students)]
    for one in day:
        one.start()
    for attack in attacks:
        attack.start()
    time.sleep(2)
    run = live_run(student, world.server, rig, seconds)
    worst_mb = idle_mb
    until = time.monotonic() + seconds + 60
    while time.monotonic() < until:
        worst_mb = max(worst_mb, memory_mb(world.server.child.pid))
        state = student.get(world.server, f"runs/{run}")
        if state.ok and state.body["state"] != "running":
            break
        time.sleep(0.25)
    for thread in attacks + day:
        thread.stop()
    reader.over.set()
    reader.join()
    for thread in attacks + day:
        thread.join(timeout=40)

    def told():
        answer = student.get(world.server, f"runs/{run}")
        return answer.body if answer.ok and answer.body["state"] != "running" else None

    ended = await_true("the run has ended", told, 60, 0.2)
    expected = int(seconds * 100)
    if ended["state"] != "finished" or ended["samples"] != expected:
        findings.append(f"the live run {ended['state']} with {ended['samples']} of {expected} samples")
    if not world.server.runs():
        findings.append("the server has ended")
    above_mb = worst_mb - idle_mb
    if above_mb > MEMORY_GOAL_MB * memory_scale:
        findings.append(f"memory rose by {above_mb:.0f} MB, more than {MEMORY_GOAL_MB * memory_scale:.0f}")
    if reader.quantile(0.99) > WAIT_GOAL_S:
        findings.append(f"another user waited {reader.quantile(0.99):.2f} s, more than {WAIT_GOAL_S}")
    if reader.failed:
        findings.append(f"another user was refused {len(reader.failed)} times: {reader.failed[:5]}")
    broken = {what: n for one in day for what, n in one.refused.items() if "failed" in what or " 5" in what}
    if broken:
        findings.append(f"students of the lab were not served: {broken}")
    figures = {
        "idle_mb": round(idle_mb),
        "above_idle_mb": round(above_mb),
        "reader_p50_s": round(reader.quantile(0.5), 3),
        "reader_p99_s": round(reader.quantile(0.99), 3),
        "reader_worst_s": round(max(reader.seconds), 3),
        "reader_requests": len(reader.seconds),
        "live_samples": ended["samples"],
        "loop": ended["loop"],
        "day": summed(one.done for one in day),
        "day_refused": summed(one.refused for one in day),
        "answers": {attack.name: attack.answers for attack in attacks},
    }
    return findings, figures


def summed(counts):
    total = {}
    for count in counts:
        for what, n in count.items():
            total[what] = total.get(what, 0) + n
    return total


def settle(pid):
    """Memory, descriptors and threads when the attackers are gone."""
    time.sleep(12)
    return {
        "memory_mb": round(memory_mb(pid)),
        "descriptors": count_of(pid, "fd"),
        "threads": count_of(pid, "task"),
    }


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", default="build/release/faultlab")
    parser.add_argument("--seconds", type=float, default=20.0, help="of each live run")
    parser.add_argument("--rounds", type=int, default=1, help="more than one: a soak")
    parser.add_argument("--memory-scale", type=float, default=1.0, help="for a program that is instrumented")
    options = parser.parse_args()
    folder = Folder()
    findings = []
    try:
        server = Server(
            options.program,
            folder,
            "hostile",
            benches=1,
            simulators=8,
            speed=1.0,
            settings='guests = "everywhere"\n',
        )
        data = folder.file("data-hostile")
        admin = make_account(options.program, server, data, "admin-1", "admin")
        student = make_account(options.program, server, data, "student", "student")
        reader = make_account(options.program, server, data, "reader", "student")
        students = [f"student-{i}" for i in range(1, 4)]
        for login in students:
            make_account(options.program, server, data, login, "student")
        world = World(server)
        upload(world)
        rig = "hostile-bench-1"
        await_rigs(admin, server, [rig], "ready")
        settled = []
        for number in range(1, options.rounds + 1):
            session = session_on(student, server, "bench")
            found, figures = round_of_attacks(
                world, student, reader, students, session["rig"], options.seconds, options.memory_scale
            )
            student.post(server, f"sessions/{session['id']}/end")
            findings += found
            after = settle(server.child.pid)
            settled.append(after)
            print(json.dumps({"round": number, **figures, "after": after}), flush=True)
        if len(settled) >= 3:
            early, late = settled[len(settled) // 3], settled[-1]
            for what, slack in (("memory_mb", 30), ("descriptors", 20), ("threads", 4)):
                if late[what] > early[what] + slack:
                    findings.append(f"{what} rose from {early[what]} to {late[what]}")
        server.child.terminate()
        server.child.wait(30)
    except Exception as error:  # noqa: BLE001
        findings.append(repr(error))
    for finding in findings:
        print(f"FOUND: {finding}")
    if findings:
        print(f"hostile: {len(findings)} findings; everything written is in {folder.path}")
        return 1
    folder.remove()
    print(f"hostile: {options.rounds} rounds, an upload of {ROWS} rows, nothing found")
    return 0


if __name__ == "__main__":
    sys.exit(main())
