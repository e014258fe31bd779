"""What people do at a lab all day, made short: each is a thread that goes on until told to stop."""

import http.client
import threading
import time

from lab import stamp
from people import LiveView, Person


def small_recording():
    lines = ["t_s,uc_v,um_v"]
    lines += [f"{k / 100:.2f},{2 + (k // 50) % 2},{0.1 + (k % 97) / 100:.4f}" for k in range(2000)]
    return ("\n".join(lines) + "\n").encode()


class Student(threading.Thread):
    """Signs in, books, practises with two viewers, exports, uploads, deletes, signs out; then again."""

    def __init__(self, server, login, address):
        super().__init__(name=login, daemon=True)
        self.server = server
        self.login = login
        self.address = address
        self.done = {}  # action -> count
        self.refused = {}  # action and status -> count
        self.over = threading.Event()

    def stop(self):
        self.over.set()

    def note(self, what, answer):
        if answer.ok:
            self.done[what] = self.done.get(what, 0) + 1
        else:
            key = f"{what} {answer.status} {answer.body.get('reason', '')}".strip()
            self.refused[key] = self.refused.get(key, 0) + 1
        return answer

    def run(self):
        while not self.over.is_set():
            try:
                self.visit()
            except (OSError, RuntimeError, KeyError, http.client.HTTPException) as error:
                key = f"failed: {error!r}"[:80]
                self.refused[key] = self.refused.get(key, 0) + 1
                self.over.wait(2)

    def visit(self):
        person = Person(self.server.port, self.login, {"X-Forwarded-For": self.address})
        self.done["sign-in"] = self.done.get("sign-in", 0) + 1
        self.book(person)
        self.practise(person)
        self.upload(person)
        self.note("sign-out", person.post(self.server, "auth/logout"))

    def book(self, person):
        start = (int(time.time()) // 900 + 20 + int(self.login[-1])) * 900
        asked = {"rig_class": "bench", "start": stamp(start), "end": stamp(start + 900)}
        booking = self.note("booking", person.post(self.server, "bookings", asked))
        if booking.ok:
            seen = {"If-Match": f'"{booking.body["version"]}"'}
            path = f"bookings/{booking.body['id']}"
            self.note("cancellation", person.delete(self.server, path, headers=seen))

    def practise(self, person):
        run = self.note("run", person.post(self.server, "runs", {"duration_s": 6}))
        if not run.ok:
            self.over.wait(1)
            return
        number = run.body["id"]
        views = [LiveView(self.server, person, number) for _ in range(2)]
        if views[0].open and views[0].command():
            self.done["command"] = self.done.get("command", 0) + 1
        until = time.monotonic() + 20
        while time.monotonic() < until and not self.over.is_set():
            if person.get(self.server, f"runs/{number}").body.get("state") != "running":
                break
            self.over.wait(0.5)
        for view in views:
            view.close()
        for part in ("export.csv", "export.mat", "plots/signals.png"):
            self.note(part, person.get(self.server, f"runs/{number}/{part}"))
        person.post(self.server, f"runs/{number}/stop")
        self.note("deletion", person.delete(self.server, f"runs/{number}"))

    def upload(self, person):
        csv = {"Content-Type": "text/csv"}
        answer = person.post(self.server, "recordings?name=mine", small_recording(), headers=csv)
        if self.note("upload", answer).ok:
            self.note("deletion", person.delete(self.server, f"runs/{answer.body['id']}"))
