"""People at work while servers fail: what they saw, and what they were promised."""

import random
import threading
import time

from people import new_person

PATIENCE_S = 6.0  # how long a user waits for a server
TICKET = {"rig_class": "bench", "min_s": 300}


def utc(seconds):
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(seconds))


class Worker:
    """Asks for places, books, cancels, practises; keeps a ledger of what was answered."""

    def __init__(self, load, person, number, seed):
        self.load = load
        self.person = person
        self.chance = random.Random(seed * 7919 + number)
        self.promised = {}  # id of a booking -> its answer
        self.cancelled = set()
        self.unclear = set()  # cancels without an answer
        self.thread = threading.Thread(target=self._work, daemon=True)

    def _server(self):
        return self.chance.choice(self.load.servers)

    def _work(self):
        while not self.load.stop.is_set():
            self.chance.choice((self._ask, self._book, self._book, self._cancel, self._practise, self._look))()
            time.sleep(self.chance.uniform(0.02, 0.12))

    def _seen(self, what, server, answer):
        self.load.seen(what, server, answer)
        return answer

    def _look(self):
        server = self._server()
        self._seen("GET auth/me", server, self.person.get(server, "auth/me", patience_s=PATIENCE_S))

    def _ask(self):
        server = self._server()
        answer = self._seen(
            "POST tickets", server, self.person.post(server, "tickets", TICKET, patience_s=PATIENCE_S)
        )
        ticket = answer.body.get("ticket", {}).get("id") if answer.ok else None
        if ticket:
            self._seen("leave", server, self.person.post(server, f"tickets/{ticket}/leave", patience_s=PATIENCE_S))

    def _book(self):
        if len(self.promised) - len(self.cancelled) >= 3:
            return
        server = self._server()
        start = (int(time.time()) // 300 + self.chance.randrange(200, 15000)) * 300
        answer = self._seen(
            "POST bookings",
            server,
            self.person.post(
                server, "bookings", {"rig_class": "bench", "start": utc(start), "end": utc(start + 300)},
                patience_s=PATIENCE_S,
            ),
        )
        if answer.status == 201:
            self.promised[answer.body["id"]] = answer.body

    def _cancel(self):
        mine = [b for b in self.promised if b not in self.cancelled and b not in self.unclear]
        if not mine:
            return
        server = self._server()
        booking = self.chance.choice(mine)
        answer = self._seen(
            "DELETE bookings",
            server,
            self.person.delete(
                server, f"bookings/{booking}", headers={"If-Match": f'"{self.promised[booking]["version"]}"'},
                patience_s=PATIENCE_S,
            ),
        )
        if answer.ok:
            self.cancelled.add(booking)
        elif answer.status == 0 or answer.status >= 500:
            self.unclear.add(booking)

    def _practise(self):
        server = self._server()
        self._seen("POST runs", server, self.person.start_run(server, "", 10, patience_s=PATIENCE_S))

    def lost(self, server):
        """Bookings that were promised and are gone, and cancels that were promised and are not."""
        answer = self.person.get(server, "bookings")
        there = {item["id"] for item in answer.body["items"]}
        gone = [b for b in self.promised if b not in self.cancelled | self.unclear and b not in there]
        back = [b for b in self.cancelled if b in there]
        return gone, back


class Load:
    def __init__(self, proof, admin, server, people, seed):
        self.proof = proof
        self.servers = [server]
        self.stop = threading.Event()
        self.lock = threading.Lock()
        self.answers = {}  # (server, "2xx" | "4xx" | "503" | "none" | other) -> count
        self.odd = {}
        self.workers = [
            Worker(self, new_person(server, admin, f"worker-{seed}-{i}"), i, seed) for i in range(people)
        ]

    def start(self, servers):
        self.servers = list(servers)
        for worker in self.workers:
            worker.thread.start()

    def seen(self, what, server, answer):
        kind = f"{answer.status // 100}xx" if answer.status else "no answer"
        if answer.status == 503:
            kind = "503"
        with self.lock:
            key = (server.name, kind)
            self.answers[key] = self.answers.get(key, 0) + 1
            if answer.status >= 500 and answer.status != 503:
                self.odd[(what, answer.status, answer.text[:200])] = True

    def end(self):
        self.stop.set()
        for worker in self.workers:
            worker.thread.join(60)

    def report(self, name, server):
        lost = back = promised = cancelled = 0
        for worker in self.workers:
            gone, there = worker.lost(server)
            lost += len(gone)
            back += len(there)
            promised += len(worker.promised)
            cancelled += len(worker.cancelled)
        for odd in self.odd:
            self.proof.broken(f"{name}: an answer that is no refusal: {odd}")
        self.proof.check(lost == 0, f"{name}: {lost} bookings lost")
        self.proof.check(back == 0, f"{name}: {back} cancelled bookings are back")
        for who in sorted({server for server, _ in self.answers}):
            counts = {kind: n for (s, kind), n in sorted(self.answers.items()) if s == who}
            self.proof.figure(
                f"{name}: answers of {who}", ", ".join(f"{n} x {k}" for k, n in counts.items())
            )
        self.proof.figure(
            f"{name}: bookings promised, cancelled, lost", f"{promised}, {cancelled}, {lost + back}"
        )


class Probe:
    """Asks one server for a place in a queue and leaves it, over and over: how long could it not?"""

    def __init__(self, server, person):
        self.server = server
        self.person = person
        self.stop = threading.Event()
        self.silences = []  # (began, seconds) between two answers other than 503
        self.slow = []
        self.thread = threading.Thread(target=self._work, daemon=True)
        self.thread.start()

    def _work(self):
        last = time.monotonic()
        while not self.stop.is_set():
            answer = self.person.post(self.server, "tickets", TICKET)
            if answer.ok:
                self.silences.append((last, answer.at - last))
                last = answer.at
                ticket = answer.body.get("ticket", {}).get("id")
                if ticket:
                    self.person.post(self.server, f"tickets/{ticket}/leave")
            time.sleep(0.02)
        self.silences.append((last, time.monotonic() - last))

    def end(self):
        self.stop.set()
        self.thread.join(60)

    def longest_s(self, since=0.0, until=float("inf")):
        return max((s for began, s in self.silences if began + s > since and began < until), default=0.0)
