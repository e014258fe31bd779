"""The program against the real Comedi: see README.md in this folder.

  comedi_proof.py --program FILE [--cache FOLDER] [--only boards,run,..]
"""

import argparse
import concurrent.futures
import json
import os
import statistics
import subprocess
import sys
import threading
import time

from laboratory import Laboratory, await_true, rig_file
from machine import HERE, SUBJECT_TO_LOAD_S, Failure, Machine, memory_image

SKIPPED = 77
RELAYS = 0x00FF00FF
NOMINAL = RELAYS & ~(1 << 17 | 1 << 19 | 1 << 21 | 1 << 6)  # levels; 0 connects
CHIP = 1  # digital = 1: an 8255
READS, AT_ONCE, AFTER_A_PERIOD = 0, 1, 2  # commands = ..: how the board converts
DELTA_S = 9.5e-3
# Two machines side by side, of about the same time. Each part needs the ones before it in its row.
ROWS = (
    ("boards", "contacts", "backwards", "failing"),
    ("run", "killed", "frozen", "unplugged"),
)
# In the machine's own time, which no load of the host stretches. A relay takes milliseconds.
KILLED_S_MAX = 0.1
FROZEN_S_MAX = 0.5
CROWDED_US_MAX = 1000
# What the program says of delta, and what the board saw of it. Half a scan is 20 us. Single reads are
# timed by the program's clock around three instructions, through the driver's thread.
CLOCKED_WITHIN_S = 15e-6
READ_WITHIN_S = 100e-6


def check(true, what):
    if not true:
        raise Failure(what)


def said(text):
    """By the row that speaks."""
    with speaking:
        for line in text.splitlines():
            print(f"{threading.current_thread().name}: {line}", flush=True)


speaking = threading.Lock()


def report_of(text):
    """The JSON of a self-test, behind what else the program said."""
    begin = text.find("{")
    return json.JSONDecoder().raw_decode(text[begin:])[0] if begin >= 0 else {}


def check_relays_nominal(board):
    check(board["lines"] & RELAYS == NOMINAL, f"the relays are not nominal: {board}")
    check(board["crowded_us"] <= CROWDED_US_MAX, f"a board connected two parts: {board}")


class Proof:
    def __init__(self, machine, commands, reverses):
        """@param commands, reverses  of the laboratory's board"""
        self.machine = machine
        self.commands = commands
        self.reverses = reverses
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
            report = report_of(text)
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

    def contacts(self):
        """Each relay position is recognised by what it does to the motor, however the board converts."""
        machine = self.machine
        machine.write("/tmp/rig.toml", rig_file("3"))
        machine.load_board(CHIP, AFTER_A_PERIOD)
        text, status = machine.sh("faultlab rig --config /tmp/rig.toml --self-test --contacts --json 2>&1")
        report = report_of(text).get("contacts", {})
        found = [position["contact"] for position in report.get("positions", [])]
        check(status == 0 and len(found) == 12, f"contacts: {text}")
        check("wrong" not in found and found.count("recognised") >= 10, f"contacts: {text}")
        check(machine.board()["commands"] > 1000, f"the board did not clock: {machine.board()}")
        said(f"  {found.count('recognised')} of 12 recognised, {found.count('read_back_only')} read back only")

    # ---- with a server ----

    def in_a_lab(self):
        """The laboratory on an 8255, its rig ready."""
        if self.lab is None:
            self.machine.load_board(CHIP, self.commands, int(self.reverses))
            self.machine.write("/tmp/rig.toml", rig_file("3", self.reverses))
            self.lab = Laboratory(self.machine)
            self.lab.await_ready()
        return self.lab

    def driven(self, seconds=30):
        """A run in its middle, R12 on its fourth position. @returns its id"""
        lab = self.in_a_lab()
        run = lab.run(seconds, faults=[{"component": "R12", "value": 2000, "at_s": 0.3}])
        lab.await_samples(run, 50)
        board = self.machine.board()
        check(board["drive_uv"] > 1e6, f"the motor is not driven: {lab.about(run)} {board}")
        check(board["lines"] & RELAYS == NOMINAL ^ (1 << 6 | 1 << 23), f"R12 is not 2 kohm: {board}")
        return run

    def samples(self, run, name, count):
        """One column of a run that has ended."""
        answer = self.lab.admin.get(self.lab, f"runs/{run}/samples?from=0&to={count}")
        column = answer.body.get(name, [])
        check(len(column) == count and None not in column, f"no {name}: {answer}")
        return column

    def check_delta(self, run, samples, board):
        """What the samples of a run that has ended carry, against what the board saw of most of them."""
        clocked = self.commands != READS
        check(clocked == (board["commands"] > 0), f"commands: {board}")
        delta_s = self.samples(run, "delta_s", samples)
        mean_s = statistics.mean(delta_s)
        rms_s = statistics.pstdev(delta_s)
        farthest_s = max(abs(each - DELTA_S) for each in delta_s)
        said(
            f"  delta by the program: {1e3 * mean_s:.4f} ms, rms {1e6 * rms_s:.1f} us, farthest {1e6 * farthest_s:.0f}"
            f" us; at the board: {1e-6 * board['delta_mean_ns']:.4f} ms, "
            f"{1e-6 * board['delta_min_ns']:.4f} to {1e-6 * board['delta_max_ns']:.4f} ms of {board['deltas']}"
        )
        off_s = abs(mean_s - 1e-9 * board["delta_mean_ns"])
        check(off_s < (CLOCKED_WITHIN_S if clocked else READ_WITHIN_S), f"the board saw another delta: {board}")

    def run(self):
        """A whole diagnosed run over REST; a stop."""
        lab = self.in_a_lab()
        run = lab.run(9, faults=[{"component": "R1", "value": 56, "at_s": 6}])
        lab.await_samples(run, 20)
        self.machine.tell_board("mark")
        lab.await_samples(run, 500)
        board = self.machine.board()
        about = lab.await_end(run)
        self.check_delta(run, 900, board)
        kinds = [event["kind"] for event in about["events"]]
        check(about["state"] == "finished" and about["samples"] == 900, f"{about}")
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
        check(diagnosis["calibration"].get("covariance_model"), "a built rig keeps the errors of noise alone")
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

    def backwards(self):
        """A motor that turns backwards: the counter gives its speed with the sign."""
        lab = self.in_a_lab()
        run = lab.run(3, excitation={"kind": "step", "low_v": 2, "high_v": -3, "at_s": 0.5})
        lab.await_end(run)
        n_rpm = self.samples(run, "n_rpm", 300)
        forwards, backwards = statistics.mean(n_rpm[30:50]), statistics.mean(n_rpm[200:])
        said(f"  {forwards:.1f} rpm at 2 V, {backwards:.1f} rpm at -3 V")
        check(forwards > 50 and -1.9 < backwards / forwards < -1.4, f"{n_rpm[::10]}")

    def tripped(self, run):
        about = self.lab.await_end(run)
        trips = [event["text"] for event in about["events"] if event["kind"] == "trip"]
        check(trips, f"no trip: {about}")
        said(f"  {about['state']}: {trips[0]}")
        return trips[0]

    def failing(self):
        """Every instruction fails with EIO in mid-run: the trip, and the supervisor when they work again."""
        lab = self.in_a_lab()
        run = self.driven()
        self.machine.tell_board("mark")
        lab.await_samples(run, 150)
        board = self.machine.board()
        # Longer than the agent tries to make the bench safe, shorter than the supervisor waits for it.
        self.machine.sh("echo fail > /proc/motor_bench; sleep 0.1; echo works > /proc/motor_bench")
        self.await_zero()
        text = self.tripped(run)
        check("Input/output error" in text, text)
        self.check_delta(run, 150, board)
        check_relays_nominal(self.machine.board())

    def unplugged(self):
        """The device goes in mid-run; rmmod is refused while it is open."""
        run = self.driven()
        text, status = self.machine.sh("rmmod motor_bench 2>&1")
        check(status != 0, f"rmmod of a board in use: {text}")
        self.machine.tell_board("unplug")
        text = self.tripped(run)
        check("No such device" in text, text)


def play(row, image, version, cache, given):
    """The parts of one row, in a machine of its own. @returns true when all are proven"""
    name = threading.current_thread().name
    machine = None
    proof = None
    try:
        machine = Machine(cache, version, image, f"{cache}/{name}.log")
        said(f"kernel {version} up after {machine.boot_s:.0f} s, {machine.processor_s():.0f} s of processor")
        first = row is ROWS[0]
        proof = Proof(machine, READS if first else AT_ONCE, reverses=first)
        for part in row:
            if part not in given.only:
                continue
            began, used = time.monotonic(), machine.processor_s()
            function = getattr(proof, part)
            said(f"{part}: {function.__doc__}")
            function()
            said(f"  proven in {time.monotonic() - began:.0f} s, {machine.processor_s() - used:.0f} s of processor")
        return True
    except Exception as failure:  # whatever it was, both logs are wanted
        said(f"FAILED: {type(failure).__name__}: {failure}")
        if proof is not None and proof.lab is not None:
            said(f"the server said:\n{proof.lab.said()[-3000:]}\nthe agent said:\n{proof.lab.agent_said()[-3000:]}")
        return False
    finally:
        if machine is not None:
            machine.end()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    parser.add_argument("--cache", default=os.path.join(HERE, "..", "..", "build", "comedi"))
    parser.add_argument("--only", default=[part for row in ROWS for part in row], type=lambda text: text.split(","))
    given = parser.parse_args()
    cache = os.path.abspath(given.cache)
    fetched = subprocess.run([os.path.join(HERE, "packages"), cache], check=False)
    if fetched.returncode != 0:
        return fetched.returncode
    began = time.monotonic()
    with open(f"{cache}/version", encoding="utf8") as text:
        version = text.read().strip()
    image = memory_image(cache, version, given.program)
    rows = [row for row in ROWS if set(row) & set(given.only)]
    with concurrent.futures.ThreadPoolExecutor(len(rows), thread_name_prefix="machine") as machines:
        proven = list(machines.map(lambda row: play(row, image, version, cache, given), rows))
    print(f"{'all proven' if all(proven) else 'FAILED'} in {time.monotonic() - began:.0f} s", flush=True)
    return 0 if all(proven) else 1


if __name__ == "__main__":
    sys.exit(main())
