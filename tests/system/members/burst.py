"""Everybody in the same second: how long people wait, with SQLite and with PostgreSQL.

The clients are threads of one Python on the same machine: the figures are upper bounds."""

import random
import threading
import time

import lab
from people import first_admin, new_person
from processes import Folder, Postgres, Server


def percentile(values, share):
    values = sorted(values)
    return values[min(len(values) - 1, int(share * len(values)))]


def burst(proof, engine, server, people, seed):
    """Each client asks who it is, asks for a place, books: its requests begin within one second."""
    chance = random.Random(seed)
    start = time.monotonic() + 0.5
    seen = []
    lock = threading.Lock()

    def work(person, number):
        delay = start + chance.uniform(0.0, 1.0) - time.monotonic()
        time.sleep(max(0.0, delay))
        day = time.time() // 300 * 300 + 86400 + number * 900
        booking = {"rig_class": "bench", "start": lab.stamp(day), "end": lab.stamp(day + 300)}
        answers = [
            ("GET auth/me", person.get(server, "auth/me")),
            ("POST tickets", person.post(server, "tickets", {"rig_class": "bench", "min_s": 300})),
            ("POST bookings", person.post(server, "bookings", booking)),
        ]
        with lock:
            seen.extend(answers)

    threads = [threading.Thread(target=work, args=each) for each in zip(people, range(len(people)))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for what in ("GET auth/me", "POST tickets", "POST bookings"):
        answers = [answer for name, answer in seen if name == what]
        odd = [str(answer) for answer in answers if not answer.ok]
        proof.check(not odd, f"burst on {engine}: {len(odd)} x {what}: {odd[:2]}")
        times = [answer.seconds * 1000 for answer in answers]
        proof.figure(
            f"burst of {len(people)} on {engine}: {what}",
            f"p50 {percentile(times, 0.5):.0f} ms, p99 {percentile(times, 0.99):.0f} ms, "
            f"longest {max(times):.0f} ms",
        )


def run(proof, options, _):
    for engine in ("SQLite", "PostgreSQL"):
        folder = Folder()
        postgres = Postgres(folder) if engine == "PostgreSQL" else None
        server = Server(
            options.program, folder, "local", postgres.url if postgres else "", benches=2, simulators=0
        )
        try:
            admin = first_admin(server)
            people = [new_person(server, admin, f"client-{i}") for i in range(options.clients)]
            lab.await_rigs(admin, server, ["bench-1"], "ready")
            burst(proof, engine, server, people, options.seed)
        finally:
            server.kill()
            if postgres:
                postgres.stop()
            folder.remove()
