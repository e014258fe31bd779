"""A server is killed (SIGKILL) in the middle of a run on a far rig and started again.

Every sample that the agent took until its run ended is then in the recording, without a gap, and the
run ends as the agent says. Real processes: `faultlab serve`, `faultlab rig` with a simulated bench,
LCM between them on a port of its own.
"""

import argparse
import csv
import glob
import io
import os
import re
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "members"))

import lab
from people import first_admin, request
from processes import Folder, Process, Server, await_true

BUS = "udpm://239.255.76.67:7693?ttl=0"
RIG = "far-1"
WATCHDOG_S = 10.0  # a machine that stands still for 2 s (seen) ends a run that no server has left
RIDE_THROUGH_S = 30


class Agent(Process):
    def __init__(self, program, folder, ride_through_s):
        super().__init__(
            [program, "rig", "--id", RIG, "--lcm", BUS, "--keys", folder.file("keys"), "--state",
             folder.file("state"), "--ride-through", str(ride_through_s), "--no-supervisor"],
            folder.file(f"agent-{time.monotonic()}.log"),
        )

    def last_stop(self):
        """@returns (samples, cause) of the newest run that was stopped"""
        found = re.findall(r"run \d+ stopped at sample (\d+), [^:]*: (.*)", self.said())
        return (int(found[-1][0]), found[-1][1]) if found else None


class World:
    def __init__(self, program, ride_through_s):
        self.program = program
        self.folder = Folder()
        os.mkdir(self.folder.file("keys"))
        self.ride_through_s = ride_through_s
        self.agent = self.new_agent()
        self.server = None

    def begin(self):
        self.start_server()
        self.admin = first_admin(self.server)
        lab.await_rigs(self.admin, self.server, [RIG], "ready")
        self.session = lab.session_on(self.admin, self.server, "bench-far-sim", RIG)

    def new_agent(self):
        return Agent(self.program, self.folder, self.ride_through_s)

    def start_server(self):
        self.server = Server(
            self.program, self.folder, "one", benches=0, simulators=0, bus=BUS,
            keys=self.folder.file("keys"),
        )

    def close(self, failed):
        for process in (self.server, self.agent):
            if process is not None:
                process.kill()
        if failed:  # a repetition that is green removes the folders
            for log in sorted(glob.glob(self.folder.file("*.log"))):
                with open(log, encoding="utf8", errors="replace") as text:
                    print(f"-- {log}\n", *text.readlines()[-60:], sep="", file=sys.stderr)
        else:
            self.folder.remove()

    def start_run(self, seconds):
        def started():
            answer = self.admin.start_run(self.server, RIG, seconds)
            self.refusal = str(answer)
            return answer.body.get("id") if answer.ok else None

        try:
            return await_true("a run starts", started, 30, 0.2)
        except TimeoutError:
            raise AssertionError(f"no run starts: {self.refusal}") from None

    def about(self, run):
        return self.admin.get(self.server, f"runs/{run}").body

    def await_samples(self, run, samples):
        await_true(f"{samples} samples", lambda: self.about(run).get("samples", 0) >= samples)

    def events(self, run):
        return self.admin.get(self.server, f"runs/{run}/events").body["items"]

    def of_kind(self, run, kind):
        return [event for event in self.events(run) if event["kind"] == kind]

    def times(self, run):
        answer = request(
            self.server.port, "GET", f"/api/v1/runs/{run}/export.csv", None, self.admin.headers
        )
        rows = csv.DictReader(line for line in io.StringIO(answer.text) if not line.startswith("#"))
        return [float(row["t_s"]) for row in rows]

    def expect_whole(self, run, samples):
        about = self.about(run)
        assert about["samples"] == samples, f"{about['samples']} samples, the agent took {samples}"
        times = self.times(run)
        assert len(times) == samples, (len(times), samples)
        for index, t_s in enumerate(times):
            assert abs(t_s - 0.01 * index) < 1e-6, f"sample {index} is of {t_s} s"
        assert not self.of_kind(run, "gap")
        for kind in ("started", "rest_fetched"):
            assert len(self.of_kind(run, kind)) == 1, (kind, self.events(run))


def the_agents_watchdog_ends_the_run(world):
    run = world.start_run(60)
    world.await_samples(run, 250)
    world.server.kill()
    samples, cause = await_true("the watchdog", world.agent.last_stop, 120)
    assert "watchdog" in cause, cause
    world.start_server()
    # A new run on the same rig would overwrite what the agent keeps: it waits.
    next_run = world.start_run(1)
    world.expect_whole(run, samples)
    stopped = world.of_kind(run, "stopped")
    assert len(stopped) == 1 and "watchdog" in stopped[0]["text"], stopped
    assert world.about(run)["state"] == "interrupted"
    diagnosis = world.admin.get(world.server, f"runs/{run}/diagnosis").body
    assert diagnosis["samples"] == samples, diagnosis
    await_true("the next run ends", lambda: world.about(next_run)["state"] == "finished")
    assert world.admin.delete(world.server, f"runs/{run}").status == 204
    print(f"  all {samples} samples are there")


def a_run_that_rides_through_ends_when_its_server_returns(world):
    """Nobody could stop it: the returned server takes the rig with a higher epoch, which does."""
    run = world.start_run(60)
    world.await_samples(run, 250)
    world.server.kill()
    time.sleep(2.0)
    world.agent.freeze()
    world.start_server()
    assert world.about(run)["state"] == "interrupted", "what the agent has is awaited"
    deleted = world.admin.delete(world.server, f"runs/{run}")
    assert deleted.status == 409 and deleted.body["reason"] == "rest_awaited", deleted
    world.agent.wake()
    woken = time.monotonic()
    samples, cause = await_true("the run is stopped", world.agent.last_stop, 120)
    stopped_s = time.monotonic() - woken
    assert "lease" in cause, cause
    world.start_run(1)  # waits for what is left
    world.expect_whole(run, samples)
    assert samples > 400, samples
    stopped = world.of_kind(run, "stopped")
    assert len(stopped) == 1 and "lease" in stopped[0]["text"], stopped
    fetched = world.of_kind(run, "rest_fetched")[0]
    print(f"  stopped {stopped_s:.2f} s after the agent could hear of it; {samples} samples, "
          f"{fetched['value']} of them fetched from {fetched['t_s']} s on")


def killed_again_while_it_reads(world):
    run = world.start_run(60)
    world.await_samples(run, 150)
    world.server.kill()
    for _ in range(3):
        world.start_server()
        time.sleep(0.7)
        world.server.kill()
    world.start_server()
    samples, _ = await_true("the run is stopped", world.agent.last_stop, 120)
    world.start_run(1)
    world.expect_whole(run, samples)


def an_agent_that_started_anew_has_nothing(world):
    run = world.start_run(60)
    world.await_samples(run, 250)
    world.server.kill()
    world.agent.kill()
    world.agent = world.new_agent()
    world.start_server()
    stored = world.about(run)["samples"]
    await_true(
        "the recording is closed",
        lambda: world.admin.delete(world.server, f"runs/{run}").status == 204, 30, 0.2,
    )
    assert stored >= 150, stored


def a_killed_agent_is_gone_within_two_seconds(world):
    run = world.start_run(60)
    world.await_samples(run, 150)
    world.agent.kill()
    killed = time.monotonic()

    def shown():
        rigs = world.admin.get(world.server, "rigs").body["items"]
        return next(rig for rig in rigs if rig["id"] == RIG)

    await_true("the rig is offline", lambda: shown()["state"] == "offline", 120)
    offline_s = time.monotonic() - killed
    await_true("the run says so", lambda: world.of_kind(run, "rig_silent"), 120)
    silent_s = time.monotonic() - killed
    assert shown()["health"] == "the agent is not heard", shown()
    if os.environ.get("FAULTLAB_PROVE") == "1":
        assert offline_s < 2.6 and silent_s < 2.8, (offline_s, silent_s)
    print(f"  offline in the list after {offline_s:.2f} s, event in the run after {silent_s:.2f} s")


def main():
    parser = argparse.ArgumentParser(prog="tests/system/recovery/run", description=__doc__)
    parser.add_argument("--program", default=os.path.join(HERE, "../../../build/ci/faultlab"))
    cases = {
        "watchdog": (the_agents_watchdog_ends_the_run, WATCHDOG_S),
        "ride_through": (a_run_that_rides_through_ends_when_its_server_returns, RIDE_THROUGH_S),
        "killed_again": (killed_again_while_it_reads, RIDE_THROUGH_S),
        "agent_gone": (a_killed_agent_is_gone_within_two_seconds, RIDE_THROUGH_S),
        "agent_anew": (an_agent_that_started_anew_has_nothing, RIDE_THROUGH_S),
    }
    parser.add_argument("--only", choices=cases)
    options = parser.parse_args()
    program = os.path.abspath(options.program)
    for case, ride_through_s in [cases[options.only]] if options.only else cases.values():
        print(case.__name__.replace("_", " "), flush=True)
        world = World(program, ride_through_s)
        failed = True
        try:
            world.begin()
            case(world)
            failed = False
        finally:
            world.close(failed)


if __name__ == "__main__":
    main()
