"""Scripts that try again: random calls of many accounts, a third of them cut off before their answer is read.

Each POST has an Idempotency-Key and is sent again until it is answered; a fifth is sent once more afterwards. Whatever
was sent how often: it was done once, every later answer is the first one, nobody has more than the policy allows, and
the server never fails.
"""

import argparse
import collections
import concurrent.futures
import http.client
import json
import os
import random
import socket
import sys
import time
import uuid

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "members"))

from lab import stamp
from people import first_admin, new_person
from processes import Folder, Server

CLASSES = ("bench", "none such")
MINUTE_S = 60


class Script:
    """One account's calls, one after the other, with its own key."""

    def __init__(self, port, key, seed):
        self.port = port
        self.random = random.Random(seed)
        self.headers = {"Authorization": f"Bearer {key}", "Content-Type": "application/json"}
        self.connection = None
        self.answers = collections.Counter()
        self.later = collections.Counter()  # why to come again
        self.cut = 0
        self.made = {"runs": set(), "jobs": set(), "bookings": set()}
        self.wrong = []

    def once(self, method, path, body, headers, cut=False):
        """(status, text), or None where the connection was cut"""
        if self.connection is None:
            self.connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=120)
        try:
            self.connection.request(method, "/api/v1/" + path, body, headers)
            if cut:
                self.cut += 1
                self.connection.sock.shutdown(socket.SHUT_RDWR)
                raise ConnectionResetError
            answer = self.connection.getresponse()
            return answer.status, answer.read().decode("utf8")
        except (OSError, http.client.HTTPException):
            self.connection.close()
            self.connection = None
            return None

    def call(self, method, path, body=None, headers=None):
        sent = {**self.headers, **(headers or {})}
        body = None if body is None else json.dumps(body)
        if method == "POST":
            sent["Idempotency-Key"] = str(uuid.UUID(int=self.random.getrandbits(128)))
        cut = method == "POST" and self.random.random() < 0.33
        until = time.monotonic() + 120
        while True:
            answer = self.once(method, path, body, sent, cut)
            if answer is not None and answer[0] not in (429, 503):
                break
            if time.monotonic() > until:
                self.wrong.append(f"{method} {path}: no answer but {answer}")
                return 0, {}
            if answer is not None:
                self.answers[answer[0]] += 1
                self.later[json.loads(answer[1])["reason"]] += 1
                time.sleep(0.05)
            cut = cut and self.random.random() < 0.3
        status, text = answer
        if method == "POST" and self.random.random() < 0.2:
            again = self.once(method, path, body, sent)
            ended = path.startswith("sessions/") and again is not None and again[0] == 404  # nothing of it is kept
            if again is None or again[0] in (429, 503) or ended:
                pass
            elif status >= 400:  # what was refused may go better next time
                status, text = again
            elif again != answer:
                self.wrong.append(f"{method} {path} {body}: {answer} and then {again}")
        self.answers[status] += 1
        if status >= 500 or status in (401, 403):
            self.wrong.append(f"{method} {path} {body}: {status} {text[:200]}")
        return status, json.loads(text) if text.startswith("{") else {}

    def items(self, path):
        return self.call("GET", path)[1].get("items", [])

    def step(self):
        dice = self.random.random()
        if dice < 0.30:
            self.queue()
        elif dice < 0.65:
            self.book()
        elif dice < 0.72:
            status, run = self.call("POST", "runs", {"duration_s": 5, "name": "once"})
            if status == 201:
                self.made["runs"].add(run["id"])
        elif dice < 0.74:
            plans = [{"duration_s": 5}] * self.random.randint(1, 3)
            status, jobs = self.call("POST", "jobs", {"runs": plans, "name": "once"})
            if status == 202:
                self.made["jobs"].add(jobs["batch"])
        else:
            self.look()

    def queue(self):
        self.call("POST", "tickets", {"rig_class": self.random.choice(CLASSES), "min_s": 300, "want_s": 600})
        tickets = self.items("tickets")
        if len(tickets) > 1:
            self.wrong.append(f"{len(tickets)} tickets at once: {tickets}")
        for ticket in tickets:
            what = self.random.choice(("accept", "leave", "wait"))
            if what != "wait":
                self.call("POST", f"tickets/{ticket['id']}/{what}")
        for session in self.items("sessions"):
            if session["state"] == "active":
                self.call("POST", f"sessions/{session['id']}/end")

    def book(self):
        bookings = self.items("bookings")
        if len(bookings) > 3:
            self.wrong.append(f"{len(bookings)} bookings at once: {bookings}")
        if bookings and self.random.random() < 0.4:
            booking = self.random.choice(bookings)
            self.call("DELETE", f"bookings/{booking['id']}", headers={"If-Match": f'"{booking["version"]}"'})
            return
        start = time.time() + MINUTE_S * self.random.randint(-5, 600)
        end = start + MINUTE_S * self.random.randint(-5, 260)
        body = {"rig_class": self.random.choice(CLASSES), "start": stamp(start), "end": stamp(end)}
        status, booked = self.call("POST", "bookings", {**body, "wait": self.random.random() < 0.5})
        if status == 201:
            if not 5 * MINUTE_S <= end - start <= 240 * MINUTE_S + 1:
                self.wrong.append(f"booked outside of the limits: {booked}")
            if booked["id"] in self.made["bookings"]:
                self.wrong.append(f"two bookings are one: {booked}")
            self.made["bookings"].add(booked["id"])

    def look(self):
        self.call("GET", self.random.choice(("sessions", "events?limit=5", "rig-classes", "jobs?limit=5", "policy")))

    def finish(self):
        """What there is of it must be what was made, each once."""
        for what in ("runs", "jobs"):
            there, cursor = [], ""
            while True:
                page = self.call("GET", f"{what}?limit=200{cursor}")[1]
                there += page["items"]
                if not page["next_cursor"]:
                    break
                cursor = f"&cursor={page['next_cursor']}"
            if what == "runs":
                found = [each["id"] for each in there if each["name"] == "once" and not each.get("job")]
            else:
                found = list({each["batch"] for each in there})
            if set(found) != self.made[what]:
                self.wrong.append(f"{len(found)} {what} for {len(self.made[what])} that were asked for")


def resident_mib(pid):
    with open(f"/proc/{pid}/status", encoding="utf8") as status:
        return next(int(line.split()[1]) // 1024 for line in status if line.startswith("VmRSS"))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    parser.add_argument("--calls", type=int, default=100_000)
    parser.add_argument("--people", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    folder = Folder()
    server = Server(options.program, folder, "one", benches=2, simulators=8, speed=1000.0)
    failed = True
    try:
        admin = first_admin(server)
        scripts = []
        for i in range(options.people):
            person = new_person(server, admin, f"person-{i}")
            key = person.post(
                server, "api-keys",
                {"name": "script", "scopes": ["jobs", "runs:read", "runs:write", "lab"],
                 "expires_at": stamp(time.time() + 24 * 3600)},
            )
            scripts.append(Script(server.port, key.body["key"], options.seed * 1000 + i))
        before = resident_mib(server.child.pid)
        began = time.monotonic()

        def work(script):
            while sum(script.answers.values()) + script.cut < options.calls / len(scripts) and not script.wrong:
                script.step()
            script.finish()

        with concurrent.futures.ThreadPoolExecutor(8) as pool:
            list(pool.map(work, scripts))
        answers = sum((script.answers for script in scripts), collections.Counter())
        cut = sum(script.cut for script in scripts)
        wrong = [each for script in scripts for each in script.wrong]
        took_s = time.monotonic() - began
        print(*wrong[:10], *sum((script.later for script in scripts), collections.Counter()).items(), sep="\n")
        print(f"{sum(answers.values()) + cut} calls in {took_s:.0f} s, {cut} cut off; "
              + ", ".join(f"{status}: {count}" for status, count in sorted(answers.items())))
        print(*(f"{what}: {sum(len(script.made[what]) for script in scripts)}" for what in scripts[0].made), sep=", ")
        print(f"memory {before} -> {resident_mib(server.child.pid)} MiB; {len(wrong)} things wrong")
        failed = bool(wrong)
    finally:
        server.kill()
        if not failed:
            folder.remove()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
