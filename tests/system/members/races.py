"""POST /runs and live commands against the end of a session, in every order that chance gives.

The oracle knows the published API alone: answers, GET /runs, GET /rig-classes, acks."""

import os
import random
import threading
import time

from people import LiveView, new_person
from processes import await_true

KINDS = ("end", "hand-over", "take-over", "booking")
RUN_S = 600.0  # of the rig's time: a run that is not stopped lasts much longer than its round
# A stopped run is shown as ended this long after the answer; without a quiet machine, a guard against hanging.
LET_GO_S = 1.5 if os.environ.get("FAULTLAB_PROVE") == "1" else 120.0
SPREAD_S = 0.020


class Lane:
    """One bench at a time, three people: who works, who comes next, who takes over."""

    def __init__(self, proof, server, admin, number, seed):
        self.proof = proof
        self.server = server
        self.admin = admin
        self.chance = random.Random(seed * 1000 + number)
        self.holder = new_person(server, admin, f"holder-{number}")
        self.next = new_person(server, admin, f"next-{number}")
        self.boss = new_person(server, admin, f"boss-{number}", "admin")
        self.slowest_stop_s = 0.0
        self.raced = {"201": 0, "refused": 0}
        self.commands = {"before": 0, "refused after": 0}

    def session_of(self, person):
        answer = person.post(
            self.server, "tickets", {"rig_class": "bench", "min_s": 300, "want_s": 300}
        )
        if "session" in answer.body:
            return answer.body["session"]
        ticket = answer.body["ticket"]["id"]

        def accepted():
            given = person.post(self.server, f"tickets/{ticket}/accept")
            return given.body if given.ok else None

        return await_true("the ticket's rig", accepted)

    def booked_session_of(self, person, race):
        """Books for a moment from now, and claims when it has come; `race` begins just before."""

        def stamp(when):
            return time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(when)) + f".{int(when % 1 * 1000):03d}Z"

        def booked():
            start = time.time() + 3.0
            answer = person.post(
                self.server, "bookings",
                {"rig_class": "bench", "start": stamp(start), "end": stamp(start + 310)},
            )
            return (answer.body, start) if answer.status == 201 else None

        booking, start = await_true("a booking", booked, every_s=0.2)
        time.sleep(max(0.0, start - time.time() - 0.01))
        race.start()

        def claimed():
            given = person.post(self.server, f"bookings/{booking['id']}/claim")
            return given.body if given.ok else None

        return await_true("the claim", claimed, every_s=0.002)

    def epoch_of(self, rig):
        for group in self.admin.get(self.server, "rig-classes").body["items"]:
            for member in group["members"]:
                if member["id"] == rig:
                    return member["epoch"]
        raise RuntimeError(f"no rig {rig}")

    def older_runs(self, rig, epoch):
        items = self.admin.get(self.server, "runs?limit=60").body["items"]
        return [
            run["id"] for run in items
            if run["state"] == "running" and run["rig"] == rig and run["epoch"] < epoch
        ]

    def stop_runs_of(self, person):
        for run in person.get(self.server, "runs?limit=5").body["items"]:
            if run["state"] == "running":
                person.post(self.server, f"runs/{run['id']}/stop")

    def check_nothing_older(self, kind, rig, epoch, told):
        """`told`: when the end of the older lease was answered."""
        while self.older_runs(rig, epoch):
            if time.monotonic() - told > LET_GO_S:
                self.proof.broken(f"{kind}: a run below epoch {epoch} lives on {rig}")
                return
            time.sleep(0.01)
        self.slowest_stop_s = max(self.slowest_stop_s, time.monotonic() - told)

    def check_commands(self, kind, view, told):
        late = [c for c, sent in view.sent.items() if sent > told and c in view.accepted]
        if late:
            self.proof.broken(f"{kind}: {len(late)} commands sent after its answer were accepted")
        self.commands["before"] += sum(1 for c in view.accepted if view.sent[c] <= told)
        self.commands["refused after"] += sum(
            1 for c, sent in view.sent.items() if sent > told and c not in view.accepted
        )

    def round(self, kind, with_live_view):
        proof, server = self.proof, self.server
        ex = self.holder
        heir = self.boss if kind == "take-over" else self.next
        outcome = {}

        def start_run(rig, offset_s):
            time.sleep(offset_s)
            outcome["run"] = ex.start_run(server, rig, RUN_S)

        if kind == "booking":
            rig = self.chance.choice([f"bench-{i + 1}" for i in range(proof.benches)])
            racer = threading.Thread(
                target=start_run, args=(rig, self.chance.uniform(0, 2 * SPREAD_S))
            )
            session = self.booked_session_of(heir, racer)
            told = time.monotonic()
            racer.join()
            if outcome["run"].ok:
                proof.broken("booking: somebody without a session has started a run")
            self.raced["refused"] += 1
            self.succeed(kind, heir, session)
            heir.post(server, f"sessions/{session['id']}/end")
            return

        session = self.session_of(ex)
        rig = session["rig"]
        view = None
        if with_live_view:
            run = ex.start_run(server, rig, RUN_S)
            if run.status != 201:
                proof.broken(f"{kind}: the holder's own run: {run}")
                return
            view = LiveView(server, ex, run.body["id"])
        if kind == "hand-over":
            ex.post(server, f"sessions/{session['id']}/handover", {"to": heir.login})

        racer = threading.Thread(target=start_run, args=(rig, self.chance.uniform(0, SPREAD_S)))
        stop = threading.Event()

        def keep_commanding():
            while view is not None and not stop.is_set() and view.open:
                view.command(self.chance.choice((100.0, 10.0)))
                time.sleep(0.012)

        commander = threading.Thread(target=keep_commanding)
        commander.start()
        racer.start()
        time.sleep(self.chance.uniform(0, SPREAD_S if with_live_view else 3 * SPREAD_S))
        path = f"sessions/{session['id']}"
        if kind == "end":
            changed = ex.post(server, f"{path}/end")
        elif kind == "hand-over":
            changed = heir.post(server, f"{path}/handover/accept")
        else:
            changed = heir.post(server, f"{path}/take-over", {"reason": "a race"})
        told = changed.at
        if not changed.ok:
            proof.broken(f"{kind}: {changed}")
        epoch = changed.body.get("epoch") or self.epoch_of(rig)
        if kind != "end":
            self.succeed(kind, heir, changed.body)
        self.check_nothing_older(kind, rig, epoch, told)
        racer.join()
        self.check_nothing_older(kind, rig, epoch, max(told, outcome["run"].at))
        self.raced["201" if outcome["run"].ok else "refused"] += 1
        time.sleep(0.05)
        stop.set()
        commander.join()
        again = ex.start_run(server, rig, RUN_S)
        if again.ok:
            proof.broken(f"{kind}: the ex-holder has started a run afterwards")
        if view is not None:
            time.sleep(0.02)
            self.check_commands(kind, view, told)
            view.close()
        if outcome["run"].ok:  # a run that was begun in time and has ended: its view accepts no
                               # command
            late = LiveView(server, ex, outcome["run"].body["id"])
            if late.open:
                late.command()
                time.sleep(0.02)
            if late.accepted:
                proof.broken(f"{kind}: a command by a new view of the ex-holder was accepted")
            late.close()
        if kind == "end":
            session = self.session_of(heir)
            self.succeed(kind, heir, session)
        heir.post(server, f"{path if kind != 'end' else 'sessions/' + str(session['id'])}/end")

    def succeed(self, kind, heir, session):
        run = heir.start_run(self.server, session["rig"], RUN_S)
        if run.status != 201:
            self.proof.broken(f"{kind}: the new holder's run: {run}")
        elif run.body["epoch"] != session["epoch"]:
            self.proof.broken(f"{kind}: the new holder's run has epoch {run.body['epoch']}")


def race(proof, server, admin, rounds, seed, lanes):
    workers = [Lane(proof, server, admin, number, seed) for number in range(lanes)]
    done = {kind: 0 for kind in KINDS}
    lock = threading.Lock()
    left = [(KINDS[i % len(KINDS)], i // len(KINDS) % 2 == 0) for i in range(rounds)]

    def work(lane):
        while True:
            with lock:
                if not left:
                    return
                kind, live = left.pop()
            try:
                lane.round(kind, live)
            except Exception as error:  # the other lanes continue; the proof has failed
                proof.broken(f"{kind}: {error!r}")
            with lock:
                done[kind] += 1
                if sum(done.values()) % 50 == 0:
                    proof.say(f"  {sum(done.values())} of {rounds} rounds")

    threads = [threading.Thread(target=work, args=(lane,)) for lane in workers]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    proof.figure("rounds", ", ".join(f"{kind} {count}" for kind, count in done.items()))
    total = {key: sum(lane.raced[key] for lane in workers) for key in workers[0].raced}
    proof.figure("raced POST /runs", f"{total['201']} began and were stopped or came first, "
                 f"{total['refused']} refused")
    counts = {key: sum(lane.commands[key] for lane in workers) for key in workers[0].commands}
    proof.figure("live commands of the ex-holder", f"{counts['before']} accepted before the change, "
                 f"{counts['refused after']} sent after it and refused or unanswered")
    slowest = max(lane.slowest_stop_s for lane in workers)
    proof.figure("longest time until GET /runs shows the older run ended", f"{slowest:.3f} s")
