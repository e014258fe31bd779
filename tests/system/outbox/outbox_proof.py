"""Messages reach webhooks at least once, whatever is killed or frozen meanwhile. Real processes, a
real HTTP receiver.

killed   a receiver answers nothing; a rig is quarantined, the server is killed (SIGKILL) while it
         sends and before it has stored the outcome, and started again; the receiver wakes: every
         message arrives, its repeats by the same X-Faultlab-Delivery, each signed
members  two servers on one PostgreSQL: each message arrives once; one of them is killed while it
         sends, and the other one sends it
"""

import argparse
import base64
import hashlib
import hmac
import http.server
import json
import os
import sys
import threading

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "members"))

import lab
from people import Person, first_admin
from processes import Folder, Postgres, Server, await_true

PARTS = ("killed", "members")
SETTINGS = "[webhooks]\ninsecure_local = true\n"
MINUTE_S = 60.0


class Receiver:
    """Takes messages, or, while frozen, reads them and gives no answer."""

    def __init__(self):
        self.taken = []  # (delivery, body)
        self.unanswered = []
        self.findings = []
        self.secret = ""
        self.thawed = threading.Event()
        self.thawed.set()
        outer = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                body = self.rfile.read(int(self.headers["Content-Length"]))
                outer.hear(self, body)

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        self.url = f"http://127.0.0.1:{self.server.server_address[1]}/hook"

    def hear(self, request, body):
        delivery = request.headers["X-Faultlab-Delivery"]
        if request.headers["webhook-id"] != delivery:
            self.findings.append("webhook-id is another than X-Faultlab-Delivery")
        signed = f"{delivery}.{request.headers['webhook-timestamp']}.".encode() + body
        key = base64.b64decode(self.secret.removeprefix("whsec_"))
        right = base64.b64encode(hmac.new(key, signed, hashlib.sha256).digest()).decode()
        if request.headers["webhook-signature"] != f"v1,{right}":
            self.findings.append("wrong signature")
        if not self.thawed.is_set():
            self.unanswered.append(delivery)
            self.thawed.wait(120)
            return  # the sender has given up long ago
        self.taken.append((delivery, json.loads(body)))
        request.send_response(204)
        request.end_headers()

    def rigs(self):
        return [body["data"].get("rig") for _, body in self.taken]


class World:
    def __init__(self, program):
        self.program = program
        self.folder = Folder()
        self.findings = []
        self.servers = {}

    def check(self, holds, text):
        if not holds:
            self.findings.append(text)
            print(f"BROKEN: {text}", flush=True)

    def start(self, name, database="", benches=2):
        server = Server(
            self.program, self.folder, name, database, benches=benches, simulators=1, tables=SETTINGS
        )
        self.servers[name] = server
        return server

    def hook(self, admin, server, receiver, kinds):
        made = admin.post(server, "webhooks", {"url": receiver.url, "kinds": kinds})
        if made.status != 201:
            raise RuntimeError(f"no webhook: {made}")
        receiver.secret = made.body["secret"]
        tried = admin.post(server, f"webhooks/{made.body['id']}/test")
        self.check(tried.body.get("taken") is True, f"the test message: {tried}")
        receiver.taken.clear()

    def quarantine(self, admin, server, rig):
        done = admin.post(server, f"rigs/{rig}/quarantine", {"reason": "smells"})
        if not done.ok:
            raise RuntimeError(f"no quarantine of {rig}: {done}")

    def killed(self):
        receiver = Receiver()
        server = self.start("a")
        admin = first_admin(server)
        lab.await_rigs(admin, server, ["a-bench-1", "a-bench-2"], "ready")
        self.hook(admin, server, receiver, ["rig_quarantined", "your_turn"])
        receiver.thawed.clear()
        self.quarantine(admin, server, "a-bench-1")
        await_true("the first attempt", lambda: receiver.unanswered, MINUTE_S)
        # While that one waits for its answer, another one is stored and not sent.
        self.quarantine(admin, server, "a-bench-2")
        server.kill()
        server = self.start("a")
        repeats = len(receiver.unanswered)
        await_true("it is sent again", lambda: len(receiver.unanswered) > repeats, MINUTE_S)
        receiver.thawed.set()
        await_true(
            "both messages arrive", lambda: {"a-bench-1", "a-bench-2"} <= set(receiver.rigs()), MINUTE_S
        )
        first = {d for d, body in receiver.taken if body["data"]["rig"] == "a-bench-1"}
        self.check(first == {receiver.unanswered[0]}, "a repeat has another X-Faultlab-Delivery")
        admin = Person(server.port, "admin")
        for rig in ("a-bench-1", "a-bench-2"):
            admin.post(server, f"rigs/{rig}/release")
        lab.await_rigs(admin, server, ["a-bench-1", "a-bench-2"], "ready")
        asked = admin.post(server, "tickets", {"rig_class": "bench", "min_s": 300, "want_s": 600})
        self.check(asked.ok, f"no ticket: {asked}")
        turns = lambda: [b for _, b in receiver.taken if b["type"] == "your_turn"]
        await_true("whose turn it is", turns, MINUTE_S)
        self.check(turns()[0]["data"]["login"] == "admin", f"whose turn it is: {turns()[0]}")
        hooks = await_true(
            "nothing waits",
            lambda: [h for h in admin.get(server, "webhooks").body["items"] if not h["waiting"]],
            MINUTE_S,
        )
        self.check(hooks[0]["delivered_at"] and hooks[0]["error"], f"the list of webhooks: {hooks}")
        self.findings += receiver.findings
        server.kill()

    def members(self):
        postgres = Postgres(self.folder)
        receiver = Receiver()
        one = self.start("m1", postgres.url, benches=3)
        admin = first_admin(one)
        two = self.start("m2", postgres.url, benches=3)
        known = lambda: [i for i, r in lab.rigs(admin, one).items() if r["status"] == "ready" and "sim" not in i]
        await_true("six benches", lambda: len(known()) >= 6, MINUTE_S)
        rigs = sorted(known())
        self.hook(admin, one, receiver, ["rig_quarantined"])
        for rig in rigs[:-1]:
            self.quarantine(admin, one, rig)
        await_true("all arrive", lambda: set(rigs[:-1]) <= set(receiver.rigs()), MINUTE_S)
        ids = [delivery for delivery, _ in receiver.taken]
        self.check(len(ids) == len(set(ids)) == len(rigs) - 1, f"sent twice: {receiver.taken}")
        receiver.thawed.clear()
        self.quarantine(admin, one, rigs[-1])
        await_true("an attempt", lambda: receiver.unanswered, MINUTE_S)
        sender = postgres.ask("SELECT member FROM outbox WHERE state = 'waiting' AND member <> ''")
        if sender:
            self.servers[sender].kill()
        receiver.thawed.set()
        await_true(f"the other one sends ({sender} is dead)", lambda: rigs[-1] in receiver.rigs(), MINUTE_S)
        self.findings += receiver.findings
        for server in (one, two):
            server.kill()
        postgres.stop()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", default=os.path.join(HERE, "../../../build/ci/faultlab"))
    parser.add_argument("--only", default=",".join(PARTS))
    options = parser.parse_args()
    world = World(options.program)
    for part in options.only.split(","):
        print(part, flush=True)
        try:
            getattr(world, part)()
        except (RuntimeError, TimeoutError) as error:
            world.check(False, f"{part}: {error}")
    if world.findings:
        print("\n".join(["FAILED", *world.findings]))
        print(f"kept: {world.folder.path}")
        return 1
    world.folder.remove()
    print("every message arrived")
    return 0


if __name__ == "__main__":
    sys.exit(main())
