"""The program against the real Comedi: see README.md in this folder.

  comedi_proof.py --program FILE [--cache FOLDER] [--only boards,run,killed,frozen,failing,unplugged]
"""

import argparse
import json
import os
import subprocess
import sys
import time

from laboratory import Laboratory, await_true, rig_file
from machine import HERE, SUBJECT_TO_LOAD_S, Failure, Machine, memory_image

SKIPPED = 77
RELAYS = 0x00FF00FF
NOMINAL = RELAYS & ~(1 << 17 | 1 << 19 | 1 << 21 | 1 << 6)  # levels; 0 connects
CHIP = 1  # digital = 1: an 8255
# In the machine's own time, which no load of the host stretches. A relay takes milliseconds.
KILLED_S_MAX = 0.1
FROZEN_S_MAX = 0.5
CROWDED_US_MAX = 1000


def check(true, what):
    if not true:
        raise Failure(what)


def said(text):
    print(text, flush=True)


def check_relays_nominal(board):
    check(board["lines"] & RELAYS == NOMINAL, f"the relays are not nominal: {board}")
    check(board["crowded_us"] <= CROWDED_US_MAX, f"a board connected two parts: {board}")


class Proof:
    def __init__(self, machine):
        self.machine = machine
        self.lab = None

    # ---- without a server ----

    def boards(self):
        """Self-test on one port of 32 lines, on three of 8 and on an 8255; what is refused."""
        machine = self.machine
        for digital, subdevices in ((0, "3"), (2, "[3, 4, 5]"), (CHIP, "3")):
            machine.load_board(digital)
            machine.tell_board("mark")
            machine.write("/tmp/rig.toml", rig_file(subdevices))
            text, status = machine.sh("faultlab rig --config /tmp/rig.toml --self-test --json 2>&1")
            check(status == 0, f"self-test on board {digital}: {text}")
            report = json.loads(text)
            check(report["ok"] and len(report["positions"]) == 16, f"self-test on board {digital}: {text}")
            board = machine.board()
            check(board["first"] == "analog out", f"before the drive is 0: {board['first']}")
            check_relays_nominal(board)
            if digital != CHIP:  # latches hold while directions change: not one relay moved
                check(board["crowded_us"] == 0, f"two parts connected: {board}")
                check(board["born_low"] == RELAYS & ~NOMINAL, f"not preset: {board['born_low']:#x}")
            said(f"  board {digital}: 16 of 16 positions, two parts connected for {board['crowded_us']} us")
        machine.load_board(2)
        machine.write("/tmp/rig.toml", rig_file("3"))
        text, status = machine.sh("faultlab rig --config /tmp/rig.toml --self-test 2>&1")
        wanted = "subdevice 3 of /dev/comedi0 has 8 lines, the description's relays use line 16"
        check(status == 1 and wanted in text, f"too few lines: {status} {text}")

    # ---- with a server ----

    def in_a_lab(self):
        """The laboratory on an 8255, its rig ready."""
        if self.lab is None:
            self.machine.load_board(CHIP)
            # Without the encoder: the mean speed of a gated count is not the speed at the sample, and
            # calibration refuses it ("farthest Ra").
            self.machine.write("/tmp/rig.toml", rig_file("3", counter=-1))
            self.lab = Laboratory(self.machine)
            said(f"  ready after its check of 3 s ({self.lab.await_ready():.0f} s)")
        return self.lab

    def driven(self, seconds=30):
        """A run in its middle, R12 on its fourth position. @returns its id"""
        lab = self.in_a_lab()
        run = lab.run(seconds, faults=[{"component": "R12", "value": 2000, "at_s": 0.5}])
        lab.await_samples(run, 100)
        board = self.machine.board()
        check(board["drive_uv"] > 1e6, f"the motor is not driven: {lab.about(run)} {board}")
        check(board["lines"] & RELAYS == NOMINAL ^ (1 << 6 | 1 << 23), f"R12 is not 2 kohm: {board}")
        return run

    def run(self):
        """A whole diagnosed run over REST; a stop."""
        lab = self.in_a_lab()
        run = lab.run(14, faults=[{"component": "R1", "value": 56, "at_s": 8}])
        about = lab.await_end(run)
        kinds = [event["kind"] for event in about["events"]]
        check(about["state"] == "finished" and about["samples"] == 1400, f"{about}")
        check("relay_confirmed" in kinds, f"no relay answered: {kinds}")
        diagnosis = await_true(
            "the diagnosis is settled",
            lambda: (lambda now: now if now.get("settled") else None)(
                lab.admin.get(lab, f"runs/{run}/diagnosis").body
            ),
            SUBJECT_TO_LOAD_S, 0.5,
        )
        check(diagnosis["verdict"] == "fault", f"{diagnosis['verdict']}: {diagnosis['reason']}")
        first = diagnosis["candidates"][0]
        check(first["component"] == "R1" and 45 < first["value"] < 67, f"{first}")
        check_relays_nominal(self.machine.board())
        loop = about["loop"]
        said(
            f"  verdict: {first['component']} = {first['value']:.1f} ohm; late at most "
            f"{loop['worst_us']} us, {loop['missed_ticks']} of {loop['ticks']} ticks missed"
        )
        run = self.driven()
        self.machine.tell_board("mark")
        lab.admin.post(lab, f"runs/{run}/stop")
        said(f"  stop by REST: drive 0 after {1e3 * self.await_zero():.1f} ms")
        check(lab.await_end(run)["state"] == "stopped", f"{lab.about(run)}")
        check_relays_nominal(self.machine.board())

    def await_zero(self):
        """@returns seconds from the mark to drive 0, measured by the board"""
        board = await_true(
            "drive 0", lambda: (lambda b: b if b["zero_after_us"] >= 0 else None)(self.machine.board()),
            SUBJECT_TO_LOAD_S, 0.05,
        )
        check(abs(board["drive_uv"]) < 1000, f"driven again: {board}")
        return board["zero_after_us"] * 1e-6

    def end_agent(self, signal, seconds_max):
        self.driven()
        lab = self.lab
        agent = lab.agent()
        self.machine.sh(f"echo mark > /proc/motor_bench; kill -{signal} {agent}")
        seconds = self.await_zero()
        said(f"  kill -{signal}: drive 0 after {1e3 * seconds:.1f} ms")
        await_true(
            "the supervisor ends",
            lambda: self.machine.sh(f"test -d /proc/{lab.supervisor}")[1] != 0, SUBJECT_TO_LOAD_S, 0.1,
        )
        check(seconds <= seconds_max, f"drive 0 only after {seconds:.3f} s")
        check_relays_nominal(self.machine.board())
        lab.start_agent()
        lab.agent()

    def killed(self):
        """SIGKILL of the agent in mid-run; it is started again."""
        self.end_agent("KILL", KILLED_S_MAX)

    def frozen(self):
        """SIGSTOP of the agent in mid-run; it is started again."""
        self.end_agent("STOP", FROZEN_S_MAX)

    def tripped(self, run):
        about = self.lab.await_end(run)
        trips = [event["text"] for event in about["events"] if event["kind"] == "trip"]
        check(trips, f"no trip: {about}")
        said(f"  {about['state']}: {trips[0]}")
        return trips[0]

    def failing(self):
        """Every instruction fails with EIO in mid-run, then works again."""
        run = self.driven()
        self.machine.tell_board("fail")
        text = self.tripped(run)
        check("Input/output error" in text, text)
        self.machine.tell_board("works")
        self.lab.end()  # makes the bench safe; only an operator could clear the trip
        self.lab = None
        board = self.machine.board()
        check(abs(board["drive_uv"]) < 1000, f"driven: {board}")
        check_relays_nominal(board)

    def unplugged(self):
        """The device goes in mid-run; rmmod is refused while it is open."""
        run = self.driven()
        text, status = self.machine.sh("rmmod motor_bench 2>&1")
        check(status != 0, f"rmmod of a board in use: {text}")
        self.machine.tell_board("unplug")
        text = self.tripped(run)
        check("No such device" in text, text)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    parser.add_argument("--cache", default=os.path.join(HERE, "..", "..", "build", "comedi"))
    parser.add_argument("--only", default="boards,run,killed,frozen,failing,unplugged")
    given = parser.parse_args()
    cache = os.path.abspath(given.cache)
    fetched = subprocess.run([os.path.join(HERE, "packages"), cache], check=False)
    if fetched.returncode != 0:
        return fetched.returncode
    began = time.monotonic()
    with open(f"{cache}/version", encoding="utf8") as text:
        version = text.read().strip()
    machine = None
    proof = None
    try:
        image = memory_image(cache, version, given.program)
        machine = Machine(cache, version, image, f"{cache}/serial.log")
        said(f"kernel {version} up after {machine.boot_s:.0f} s")
        proof = Proof(machine)
        for name in given.only.split(","):
            part = getattr(proof, name)
            said(f"{name}: {part.__doc__}")
            part()
        said(f"all proven in {time.monotonic() - began:.0f} s")
        return 0
    except Exception as failure:  # whatever it was, both logs are wanted
        said(f"FAILED: {type(failure).__name__}: {failure}")
        if proof is not None and proof.lab is not None:
            said(f"the server said:\n{proof.lab.said()[-3000:]}\nthe agent said:\n{proof.lab.agent_said()[-3000:]}")
        return 1
    finally:
        if machine is not None:
            machine.end()


if __name__ == "__main__":
    sys.exit(main())
