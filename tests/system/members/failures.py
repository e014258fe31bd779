"""Two servers on one PostgreSQL, and one rig on a bus, while each of them fails in turn."""

import os
import random
import time

import lab
from load import Load, Probe
from people import LiveView, first_admin, new_person
from processes import Agent, Server, await_true

LEASE_S = 10.0  # of a member
GONE_S = LEASE_S + 4.0  # until the others have noticed, in their turns of one second
WRITER_S = 3.0  # after it PostgreSQL takes back what a frozen server has locked
FREEZE_S = 6.0
BUS = "udpm://239.255.76.67:7667?ttl=0"
FAR = "far-1"


class World:
    """Servers a (real time) and b (20 times faster), two benches each, and a rig that both hear."""

    def __init__(self, proof, options, folder, postgres):
        self.proof = proof
        self.options = options
        self.folder = folder
        self.postgres = postgres
        self.chance = random.Random(options.seed)
        self.agent = None
        self.bus = {}
        if options.bus:
            os.makedirs(folder.file("keys"))
            self.bus = {"bus": BUS, "keys": folder.file("keys")}
            self.agent = Agent(options.program, folder, FAR, BUS)
            await_true("the agent's key", lambda: os.path.exists(folder.file(f"keys/{FAR}.key")))
        self.a = self.start("a", 1.0)
        self.admin = first_admin(self.a)
        self.b = self.start("b", 20.0)
        lab.await_rigs(self.admin, self.b, self.benches("a") + self.benches("b"), "ready")
        if self.agent:
            lab.await_rigs(self.admin, self.b, [FAR], "ready")
        self.people = 0

    def start(self, name, speed, **more):
        return Server(
            self.options.program, self.folder, name, self.postgres.url, benches=2, simulators=2,
            speed=speed, **self.bus, **more,
        )

    @staticmethod
    def benches(name):
        return [f"{name}-bench-1", f"{name}-bench-2"]

    def person(self, role="student"):
        self.people += 1
        return new_person(self.b, self.admin, f"person-{self.people}", role)

    def load(self, people=6):
        return Load(self.proof, self.admin, self.b, people, self.chance.randrange(10**6))

    def end(self):
        for process in (self.a, self.b, self.agent):
            if process and process.runs():
                process.wake()
                process.kill()


def sentence(person, server, topic):
    """The newest news of this topic."""
    items = person.get(server, "events").body.get("items", [])
    texts = [item["text"] for item in items if item["topic"] == topic]
    return texts[-1] if texts else ""


def booking_on(world, wanted, in_s):
    """Somebody's booking whose plan is a rig of `wanted`."""
    for _ in range(8):
        who = world.person()
        start = time.time() + in_s
        made = who.post(
            world.b, "bookings",
            {"rig_class": "bench", "start": lab.stamp(start), "end": lab.stamp(start + 400)},
        )
        if made.status == 201 and made.body["rig"].startswith(wanted):
            return who, made.body
        if made.status == 201:
            who.delete(world.b, f"bookings/{made.body['id']}", headers={"If-Match": f'"{made.body["version"]}"'})
        in_s += 0.1
    raise RuntimeError(f"no booking on {wanted}: {made}")


def killed(world):
    """kill -9 of a under load: with a run, with a booking that begins while it is dead, and with
    one that is claimed through b before b knows."""
    proof, b, admin = world.proof, world.b, world.admin
    load = world.load()
    holder = world.person()
    session = lab.session_on(holder, world.a, "bench", "a-")
    run = holder.start_run(world.a, session["rig"], 600)
    proof.check(run.status == 201, f"killed: {run}")
    late, booking = booking_on(world, "a-", 25.0)
    load.start([world.a, b])
    probe = Probe(b, world.person())
    time.sleep(3)
    world.a.kill()
    died = time.monotonic()
    load.servers = [b]
    await_true(
        "a's rigs offline at b",
        lambda: all(
            lab.rigs(admin, b).get(rig, {}).get("status") == "offline" for rig in world.benches("a")
        ),
        60, 0.1,
    )
    proof.figure("killed: until a's rigs are offline", f"{time.monotonic() - died:.1f} s")
    proof.check(time.monotonic() - died < GONE_S, "killed: a's rigs were bookable for too long")
    state = lab.run_state(holder, b, run.body["id"])
    proof.check(state == "interrupted", f"killed: the run of the dead server is {state}")
    mine = holder.get(b, "sessions").body["items"]
    proof.check(not mine, f"killed: the session on the dead server lives: {mine}")
    proof.check(sentence(holder, b, "rig_failed"), "killed: nobody told the holder")
    proof.check(not probe.longest_s(died) > 1.0, f"killed: b had no answer for {probe.longest_s(died):.2f} s")
    proof.figure("killed: longest time without an answer of b", f"{probe.longest_s(died):.2f} s")

    def claimed():
        answer = late.post(b, f"bookings/{booking['id']}/claim")
        return answer if answer.status != 503 and answer.body.get("reason") != "booking_early" else None

    answer = await_true("the claim of a booking on a dead rig", claimed, 60, 0.2)
    if answer.ok:
        proof.check(answer.body["rig"].startswith("b-"), f"killed: claimed {answer.body['rig']}")
        moved = sentence(late, b, "moved")
        proof.check("does not answer" in moved, f"killed: moved for '{moved}'")
        proof.figure("killed: the booking on its rig", f"moved to {answer.body['rig']}: {moved}")
        late.post(b, f"sessions/{answer.body['id']}/end")
    else:
        fell = sentence(late, b, "unfulfilled")
        proof.check("nothing is charged" in fell, f"killed: the booking fell without a reason: {answer}")
        proof.figure("killed: the booking on its rig", fell)
    load.end()
    probe.end()
    load.report("killed", b)
    world.a = world.start("a", 1.0)
    took = lab.await_rigs(admin, b, world.benches("a"), "ready")
    proof.figure("killed: a started again, its benches checked", f"{took:.1f} s")


def claimed_on_a_dead_rig(world):
    """The rig is held for a booking when its server dies; the claim comes before b knows. The session moves to an
    equal rig, or ends if none is free; its holder is told why."""
    proof, b = world.proof, world.b
    who, booking = booking_on(world, "a-", 2.0)
    await_true(
        "the booking is held",
        lambda: any(
            item["id"] == booking["id"] and item["state"] == "held"
            for item in who.get(b, "bookings").body["items"]
        ),
        20, 0.05,
    )
    world.a.kill()
    claim = who.post(b, f"bookings/{booking['id']}/claim")
    proof.figure("dead rig: a claim in the lease's last seconds", f"{claim.status} {claim.body.get('rig', '')}")

    def left():
        sessions = who.get(b, "sessions").body["items"]
        return not any(session["rig"].startswith("a-") for session in sessions)

    await_true("no session is on the dead rig", left, 40, 0.2)
    sessions = who.get(b, "sessions").body["items"]
    told = sentence(who, b, "moved" if sessions else "rig_failed")
    proof.check("does not answer" in told, f"dead rig: the holder was told '{told}'")
    for session in sessions:
        who.post(b, f"sessions/{session['id']}/end")
    world.a = world.start("a", 1.0)
    lab.await_rigs(world.admin, b, world.benches("a"), "ready")


def frozen(world):
    """SIGSTOP of a under load: often for a moment, once for longer than its lease."""
    proof, b, admin = world.proof, world.b, world.admin
    load = world.load()
    load.start([world.a, b])
    probe = Probe(b, world.person())
    time.sleep(5)
    before = probe.longest_s()  # time of an answer on this machine while no server is frozen
    proof.figure("frozen: longest time without an answer of b before", f"{before:.2f} s")
    longest = 0.0
    for _ in range(world.options.freezes):
        time.sleep(world.chance.uniform(0.2, 1.5))
        began = time.monotonic()
        world.a.freeze()
        time.sleep(FREEZE_S)
        world.a.wake()
        time.sleep(0.3)
        longest = max(longest, probe.longest_s(began, began + FREEZE_S))
    proof.figure(f"frozen {world.options.freezes} x {FREEZE_S:.0f} s: longest time without an answer of b", f"{longest:.2f} s")
    proof.check(longest < before + WRITER_S + 0.5, f"frozen for {FREEZE_S:.0f} s: b had no answer for {longest:.2f} s")

    time.sleep(3)
    holder = world.person()
    session = lab.session_on(holder, world.a, "bench", "a-")
    run = holder.start_run(world.a, session["rig"], 600)
    view = LiveView(world.a, holder, run.body["id"])
    view.command()
    await_true("a live command", lambda: view.accepted, 20)
    world.a.freeze()
    began = time.monotonic()
    time.sleep(world.options.long_freeze)
    longest = probe.longest_s(began, time.monotonic())
    proof.figure(f"frozen for {world.options.long_freeze:.0f} s: longest time without an answer of b", f"{longest:.2f} s")
    proof.check(
        longest < before + WRITER_S + 0.5, f"frozen for {world.options.long_freeze:.0f} s: b had no answer for {longest:.2f} s"
    )
    state = lab.run_state(holder, b, run.body["id"])
    proof.check(state == "interrupted", f"frozen: its run is {state} at b")
    world.a.wake()
    woke = time.monotonic()
    last_command = woke
    while time.monotonic() - woke < 3.0:
        if view.open and view.command() is None:
            break
        time.sleep(0.02)
    for command in view.accepted:
        if view.sent[command] > woke:
            last_command = max(last_command, view.accepted[command])
    proof.figure("frozen: commands of the fenced run accepted after waking for", f"{last_command - woke:.2f} s")
    proof.check(last_command == woke, f"frozen: the fenced run took commands for {last_command - woke:.2f} s after waking")
    again = holder.start_run(world.a, session["rig"], 10)
    proof.check(again.status == 403, f"frozen: a run after the session's end: {again}")
    await_true(
        "the fenced run is over at a",
        lambda: lab.run_state(holder, world.a, run.body["id"]) == "interrupted", 20, 0.1,
    )
    load.end()
    probe.end()
    load.report("frozen", b)
    took = lab.await_rigs(admin, b, world.benches("a"), "ready")
    proof.figure("frozen: until a is a member again and its benches checked", f"{took:.1f} s")


def passed_on(world):
    """A session on a's bench is taken over through b: how long does a take the old holder's word?"""
    proof = world.proof
    boss = world.person("admin")
    longest = 0.0
    for _ in range(10):
        holder = world.person()
        session = lab.session_on(holder, world.a, "bench", "a-")
        run = holder.start_run(world.a, session["rig"], 600)
        view = LiveView(world.a, holder, run.body["id"])
        time.sleep(world.chance.uniform(0.0, 1.0))
        taken = await_true(
            "b knows a's newest session",
            lambda: (lambda answer: answer if answer.ok else None)(
                boss.post(world.b, f"sessions/{session['id']}/take-over", {"reason": "a test"})
            ),
            20, 0.02,
        )
        while view.open and time.monotonic() - taken.at < 1.5 and view.command() is not None:
            time.sleep(0.02)
        late = [view.sent[c] - taken.at for c in view.accepted if view.sent[c] > taken.at]
        longest = max([longest, *late])
        heir = boss.start_run(world.a, session["rig"], 5)
        proof.check(heir.status == 201, f"passed on: the new holder's run: {heir}")
        boss.post(world.b, f"sessions/{session['id']}/end")
    proof.figure("passed on through the other server: the old holder commands on for", f"{longest:.2f} s")
    proof.check(longest < 1.2, f"passed on: the old holder's commands were taken for {longest:.2f} s")


def database_away(world):
    """PostgreSQL restarts three times under load, then is away for 13 s while a rig is checked."""
    proof, b, admin = world.proof, world.b, world.admin
    load = world.load()
    holder = world.person()
    session = lab.session_on(holder, world.a, "bench", "a-")
    run = holder.start_run(world.a, session["rig"], 600)
    load.start([world.a, b])
    probe = Probe(b, world.person())
    for _ in range(3):
        time.sleep(2.5)
        began = time.monotonic()
        world.postgres.restart()
        time.sleep(1.5)
        proof.figure("database restarted: b had no answer for", f"{probe.longest_s(began):.2f} s")
    state = lab.run_state(holder, world.a, run.body["id"])
    proof.figure("database restarted: a run that was going on is", state)
    mine = holder.get(world.a, "sessions").body.get("items", [])
    proof.check(mine and mine[0]["epoch"] == session["epoch"], "restart: the session is gone")
    load.end()
    probe.end()
    load.report("restarted", b)

    holder.post(world.a, f"sessions/{session['id']}/end")
    await_true("the check begins", lambda: lab.rigs(admin, b)[session["rig"]]["status"] == "cleaning", 20, 0.02)
    time.sleep(0.5)
    world.postgres.stop()
    time.sleep(13)
    world.postgres.start()
    back = time.monotonic()
    try:
        lab.await_rigs(admin, b, world.benches("a") + world.benches("b"), "ready", 40)
        proof.figure("check during an outage of 13 s: ready after the outage", f"{time.monotonic() - back:.1f} s")
    except TimeoutError as error:
        proof.broken(f"check during an outage of 13 s: {error}")


def owner_of(world):
    """The server that drives the far rig, and the other one. Each passes on what is the other's, so no answer tells."""
    name = world.postgres.ask(f"SELECT server FROM lab_rig WHERE id = '{FAR}'")
    return (world.a, world.b) if name == world.a.name else (world.b, world.a)


def never_quarantined(world, server, act, patience_s=90.0):
    """Waits until `act` is true; the far rig is never in quarantine meanwhile."""
    began = time.monotonic()

    def step():
        rig = lab.rigs(world.admin, server).get(FAR, {})
        world.proof.check(rig.get("status") != "quarantined", f"far rig: quarantined: {rig}")
        return act(rig)

    await_true(f"the far rig at {server.name}", step, patience_s, 0.2)
    return time.monotonic() - began


def far_rig(world):
    """The rig on the bus: its owner is killed, then frozen, while it drives a run."""
    proof = world.proof
    rig_class = next(
        group["id"] for group in world.admin.get(world.b, "rig-classes").body["items"]
        if any(member["id"] == FAR for member in group["members"])
    )
    for how in ("killed", "frozen"):
        holder, heir = world.person(), world.person()
        lab.session_on(holder, world.b, rig_class, FAR)
        owner, other = owner_of(world)
        run = holder.start_run(other, FAR, 120).body  # passed on to the owner
        view = LiveView(owner, holder, run["id"])
        for server in (owner, other):
            refused = holder.start_run(server, FAR, 10)
            proof.check(refused.body.get("reason") == "rig_in_use", f"far rig: two runs on it: {refused}")
        time.sleep(2)
        owner.kill() if how == "killed" else owner.freeze()
        took = never_quarantined(world, other, lambda rig: rig.get("status") == "ready")
        proof.figure(f"far rig, owner {how}: ready at the other one after", f"{took:.1f} s")
        lab.session_on(heir, other, rig_class, FAR)
        started = heir.start_run(other, FAR, 10)
        proof.check(started.status == 201, f"far rig, owner {how}: the new owner's run: {started}")
        if how == "frozen":
            owner.wake()
            woke = time.monotonic()
            while view.open and time.monotonic() - woke < 2.0 and view.command() is not None:
                time.sleep(0.02)
            late = [c for c in view.accepted if view.sent[c] > woke]
            proof.check(not late, f"far rig: {len(late)} commands of the fenced run were accepted")
        ended = await_true(
            "the new owner's run",
            lambda: (lambda s: s if s != "running" else "")(lab.run_state(heir, other, started.body["id"])),
            40, 0.2,
        )
        proof.check(ended == "finished", f"far rig, owner {how}: the new owner's run is {ended}")
        proof.check(lab.run_state(holder, other, run["id"]) == "interrupted", "far rig: the old run is not interrupted")
        for session in heir.get(other, "sessions").body["items"]:
            heir.post(other, f"sessions/{session['id']}/end")
        if how == "killed":
            restarted = world.start(owner.name, 1.0 if owner.name == "a" else 20.0)
            if owner is world.a:
                world.a = restarted
            else:
                world.b = restarted
        never_quarantined(world, world.b, lambda rig: rig.get("status") == "ready")


def stored_right(world):
    """After the end no run is `running`, and no two were on one rig."""
    runs = lab.all_runs(world.admin, world.b)
    doubles = lab.double_allocations(runs)
    world.proof.check(not doubles, f"two on one rig: {doubles}")
    counts = {}
    for run in runs:
        counts[run["state"]] = counts.get(run["state"], 0) + 1
    world.proof.figure("runs at the end", ", ".join(f"{n} {state}" for state, n in sorted(counts.items())))
    world.proof.figure("double allocations", len(doubles))


def ends_are_stored(world):
    """No run is stored as running when nobody runs it."""
    for server in (world.a, world.b):
        for run in lab.all_runs(world.admin, server):
            if run["state"] == "running":
                world.admin.post(server, f"runs/{run['id']}/stop")
    time.sleep(4)
    lost = [run for run in lab.all_runs(world.admin, world.b) if run["state"] == "running"]
    world.proof.figure("runs whose end could not be stored", len(lost))
    lab.await_no_run(world.admin, world.b)


def run(proof, options, folder, postgres):
    world = World(proof, options, folder, postgres)
    steps = [killed, claimed_on_a_dead_rig, passed_on, frozen, database_away]
    if world.agent:
        steps.append(far_rig)
    wanted = [word for word in options.steps.split(",") if word]
    steps = [step for step in steps if not wanted or step.__name__ in wanted]
    steps += [ends_are_stored, stored_right]
    try:
        for step in steps:
            proof.say(f"-- {step.__name__}: {step.__doc__.splitlines()[0]}")
            try:
                step(world)
            except Exception as error:  # the next step may still give information
                proof.broken(f"{step.__name__}: {error!r}")
    finally:
        world.end()
