"""What could keep a lease for ever, or bring an old one back: practice that is killed, a second
process of the same name, a database from a backup."""

import subprocess
import threading
import time

import lab
from people import Person, first_admin, new_person
from processes import Agent, Server, await_true

BUS = "udpm://239.255.76.68:7668?ttl=0"
SIMULATORS = 8
SPEED = 200.0


def practice(proof, options, folder, postgres):
    """Practice runs with kill -9 and a restart of the database in between: is every simulator free?"""
    def start():
        return Server(
            options.program, folder, "p", postgres.url, benches=0, simulators=SIMULATORS, speed=SPEED
        )

    server = start()
    admin = first_admin(server)
    people = [new_person(server, admin, f"trainee-{i}") for i in range(4)]
    begun, refused = [], []
    state = {"server": server, "left": options.practice}
    lock = threading.Lock()

    def work(person):
        while True:
            with lock:
                if state["left"] <= 0:
                    return
            answer = person.start_run(state["server"], "", 5, patience_s=10)
            with lock:
                if answer.status == 201:
                    state["left"] -= 1
                    begun.append(answer.body["id"])
                else:
                    refused.append(answer.status)
            if answer.status != 201:
                time.sleep(0.02)

    threads = [threading.Thread(target=work, args=(person,), daemon=True) for person in people]
    for thread in threads:
        thread.start()
    for share in (0.75, 0.5, 0.25):
        await_true("practice goes on", lambda: state["left"] < options.practice * share, 300, 0.01)
        state["server"].kill()
        state["server"] = start()
        time.sleep(0.2)
        postgres.restart()
    for thread in threads:
        thread.join(300)
    server = state["server"]
    ids = [f"p-sim-{i + 1}" for i in range(SIMULATORS)]
    took = lab.await_rigs(admin, server, ids, "ready", 60)
    proof.figure(f"practice: {len(begun)} runs, 3 x kill -9 and restart: all {SIMULATORS} free after", f"{took:.1f} s")
    answers = [None] * SIMULATORS

    def once_more(i):
        answers[i] = people[i % 4].start_run(server, "", 5)

    threads = [threading.Thread(target=once_more, args=(i,)) for i in range(SIMULATORS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    proof.check(all(a.status == 201 for a in answers), f"practice: {[str(a) for a in answers if a.status != 201]}")
    lab.await_no_run(admin, server)
    doubles = lab.double_allocations(lab.all_runs(admin, server), speed=SPEED)
    proof.check(not doubles, f"practice: two on one simulator: {doubles}")
    server.kill()


def same_name(proof, options, folder, postgres):
    """A second process of the same server_id, and a restart of the first within its lease."""
    first = Server(options.program, folder, "same", postgres.url, benches=1, simulators=1)
    began = time.monotonic()
    second = Server(
        options.program, folder, "same", postgres.url, benches=1, simulators=1, suffix="-2", wait=False
    )
    second.child.wait(60)
    proof.figure("same server_id: the second one gives up after", f"{time.monotonic() - began:.1f} s")
    proof.check(second.child.returncode != 0, "same server_id: the second one serves")
    proof.check("server_id" in second.said(), f"same server_id: it says {second.said()[-300:]}")
    proof.check(first.runs(), "same server_id: the first one has died")
    first.kill()
    began = time.monotonic()
    again = Server(options.program, folder, "same", postgres.url, benches=1, simulators=1)
    proof.figure("same server_id: restarted after kill -9, serves after", f"{time.monotonic() - began:.1f} s")
    again.kill()


def restored(proof, options, folder, postgres):
    """The database comes from a backup and is behind the rig: closed until an operator adopts it."""
    keys = {"bus": BUS, "keys": folder.file("keys")}
    agent = Agent(options.program, folder, "far-2", BUS)
    time.sleep(0.5)

    def start():
        return Server(options.program, folder, "r", postgres.url, benches=0, simulators=0, **keys)

    server = start()
    try:
        admin = Person(server.port, "admin")
        person = new_person(server, admin, "restorer")
        lab.await_rigs(admin, server, ["far-2"], "ready")
        server.kill()
        server = start()
        try:
            lab.await_rigs(admin, server, ["far-2"], "ready", 30)
        except TimeoutError as error:
            proof.broken(f"restarted: {error}")
            admin.post(server, "rigs/far-2/release")
            lab.await_rigs(admin, server, ["far-2"], "ready")
        backup = folder.file("backup")
        subprocess.run(
            [f"{postgres.bin}/pg_dump", "-h", postgres.home, "-U", "postgres", "-Fc", "-f", backup, "lab"],
            check=True,
        )
        rig_class = next(
            group["id"] for group in admin.get(server, "rig-classes").body["items"]
            if any(member["id"] == "far-2" for member in group["members"])
        )
        for _ in range(2):
            session = lab.session_on(person, server, rig_class, "far-2")
            person.post(server, f"sessions/{session['id']}/end")
            lab.await_rigs(admin, server, ["far-2"], "ready")
        seen = lab.rigs(admin, server)["far-2"]["epoch"]
        server.kill()
        subprocess.run(
            [f"{postgres.bin}/pg_restore", "-h", postgres.home, "-U", "postgres", "-d", "lab", "--clean", backup],
            check=True,
        )
        server = start()
        lab.await_rigs(admin, server, ["far-2"], "quarantined", 60)
        rig = lab.rigs(admin, server)["far-2"]
        proof.check("adopt" in rig["reason"], f"restored: the reason is '{rig['reason']}'")
        proof.check(rig["epoch"] < seen, f"restored: epoch {rig['epoch']}, the rig has seen {seen}")
        adopted = admin.post(server, "rigs/far-2/adopt")
        proof.check(adopted.ok, f"restored: {adopted}")
        lab.await_rigs(admin, server, ["far-2"], "ready")
        session = lab.session_on(person, server, rig_class, "far-2")
        proof.check(session["epoch"] > seen, f"restored: a lease of epoch {session['epoch']}")
        run = person.start_run(server, "far-2", 5)
        proof.check(run.status == 201, f"restored: {run}")
        proof.figure("restored: the rig had seen epoch, first lease after adoption", f"{seen}, {session['epoch']}")
    finally:
        server.kill()
        agent.kill()


def run(proof, options, folder, postgres):
    steps = [practice, same_name]
    if options.bus:
        steps.append(restored)
    for step in steps:
        proof.say(f"-- {step.__name__}: {step.__doc__.splitlines()[0]}")
        try:
            step(proof, options, folder, postgres)
        except Exception as error:  # the next step may still give information
            proof.broken(f"{step.__name__}: {error!r}")
