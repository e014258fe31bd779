"""Agent and server in the machine, used from outside by the published API."""

import os
import re
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "system", "members"))

import lab
import people
from machine import SUBJECT_TO_LOAD_S, Failure
from processes import await_true

BUS = "udpm://239.255.76.67:7667?ttl=0"
RIG = "bench-1"


def rig_file(digital, reverses=False):
    return (
        f'id = "{RIG}"\nclass = "comedi-bench"\nbench = "/counted.toml"\ndriver = "comedi"\n'
        f'[comedi]\ndigital = {digital}\ncounter = 2\ncounts = "both"\n[link]\nride_through_s = 30\n'
    ) + ("[limits]\nuc_min_v = -5\n[amplifier]\nquadrants = 4\n" if reverses else "")


class KeyHolder(people.Person):
    """Signed in by a key of the command line: passwords take long on an emulated processor."""

    def __init__(self, machine, login, role):
        machine.sh(f"faultlab admin users add {login} --role {role} --data /tmp/data")
        said, status = machine.sh(
            f"faultlab admin keys add {login} --scope runs:read --scope runs:write --scope lab --data /tmp/data"
        )
        key = re.search(r"\bfl[a-z]*_[A-Za-z0-9_-]+", said)
        if status != 0 or key is None:
            raise Failure(f"no key for {login}: {said}")
        self.login = login
        self.headers = {"Authorization": f"Bearer {key.group(0)}"}


class Laboratory:
    """A server, and an agent that can be started again."""

    def __init__(self, machine):
        self.machine = machine
        self.port = machine.port
        machine.sh(
            f"setsid faultlab serve --listen 0.0.0.0:8080 --data /tmp/data --sim-rigs 0 --lcm '{BUS}' "
            "> /tmp/server.log 2>&1 & true"
        )
        self.start_agent()
        await_true("the server listens", lambda: "listening on" in self.said(), SUBJECT_TO_LOAD_S, 0.2)
        self.admin = KeyHolder(machine, "boss", "admin")
        self.session = None

    def said(self):
        return self.machine.sh("cat /tmp/server.log")[0]

    def agent_said(self):
        return self.machine.sh("cat /tmp/agent.log")[0]

    def start_agent(self):
        said, _ = self.machine.sh(
            f"setsid faultlab rig --config /tmp/rig.toml --lcm '{BUS}' >> /tmp/agent.log 2>&1 & echo pid $!"
        )
        self.supervisor = int(re.search(r"pid (\d+)", said).group(1))

    def agent(self):
        """The process that drives the bench: the supervisor's child."""

        def child():
            table = self.machine.sh("cat /proc/[0-9]*/stat 2>/dev/null")[0]
            for line in table.splitlines():
                process, parent = re.match(r"(\d+) \(.*\) \S (\d+)", line).groups()
                if int(parent) == self.supervisor:
                    return int(process)
            return None

        return await_true("the agent runs", child, SUBJECT_TO_LOAD_S, 0.1)

    def rig(self):
        return lab.rigs(self.admin, self).get(RIG, {})

    def await_ready(self):
        """@returns seconds"""
        began = time.monotonic()
        await_true(
            f"{RIG} is ready", lambda: self.rig().get("status") in ("ready", "in_use"), SUBJECT_TO_LOAD_S, 0.2
        )
        return time.monotonic() - began

    def run(self, seconds, **more):
        """Starts a run in this lab's session. @returns its id"""
        if self.session is None:
            self.session = lab.session_on(self.admin, self, "comedi-bench", RIG)

        def started():
            answer = self.admin.post(self, "runs", {"rig": RIG, "duration_s": seconds, **more})
            self.refusal = str(answer)
            return answer.body["id"] if answer.ok else None

        try:
            return await_true("a run starts", started, SUBJECT_TO_LOAD_S, 0.3)
        except TimeoutError:
            raise Failure(f"no run starts: {self.refusal}; the rig: {self.rig()}") from None

    def about(self, run):
        return self.admin.get(self, f"runs/{run}").body

    def await_end(self, run):
        return await_true(
            f"run {run} ends",
            lambda: (lambda now: now if now.get("state") not in (None, "running") else None)(self.about(run)),
            SUBJECT_TO_LOAD_S, 0.2,
        )

    def await_samples(self, run, samples):
        await_true(
            f"{samples} samples of run {run}",
            lambda: self.about(run).get("samples", 0) >= samples or self.about(run).get("state") != "running",
            SUBJECT_TO_LOAD_S, 0.1,
        )
