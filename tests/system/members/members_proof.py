"""Proves, on real servers, that a rig has one lease and that servers are members. See README.md."""

import argparse
import os
import sys
import threading
import time

import burst
import failures
import leases
import races
from people import first_admin
from processes import Folder, Postgres, Server

HERE = os.path.dirname(os.path.abspath(__file__))
PARTS = ("races", "failures", "leases", "burst")


class Proof:
    """What was promised and did not hold, and the figures of the report."""

    def __init__(self):
        self.findings = []
        self.figures = []
        self.lock = threading.Lock()
        self.began = time.monotonic()
        self.benches = 8

    def say(self, text):
        print(f"[{time.monotonic() - self.began:6.1f} s] {text}", flush=True)

    def broken(self, text):
        with self.lock:
            self.findings.append(text)
        self.say(f"BROKEN: {text}")

    def check(self, holds, text):
        if not holds:
            self.broken(text)
        return holds

    def figure(self, name, value):
        with self.lock:
            self.figures.append((name, str(value)))
        self.say(f"  {name}: {value}")


def settings():
    parser = argparse.ArgumentParser(prog="tests/system/members/run", description=__doc__)
    parser.add_argument("--program", default=os.path.join(HERE, "../../../build/ci/faultlab"))
    parser.add_argument("--rounds", type=int, default=500, help="races, 500 by default")
    parser.add_argument("--freezes", type=int, default=20, help="short freezes, 20 by default")
    parser.add_argument("--long-freeze", type=float, default=60.0, help="seconds, 60 by default")
    parser.add_argument("--practice", type=int, default=1000, help="practice runs, 1000 by default")
    parser.add_argument("--clients", type=int, default=200, help="of the burst, 200 by default")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default=",".join(PARTS), help="parts: " + ", ".join(PARTS))
    parser.add_argument("--steps", default="", help="of the part failures: killed, frozen, ..; all by default")
    parser.add_argument("--bus", action="store_true", help="a private loopback carries multicast")
    parser.add_argument("--keep", action="store_true", help="leave the logs, whatever comes out")
    return parser.parse_args()


def run_races(proof, options, folder, postgres):
    server = Server(options.program, folder, "races", postgres.url, benches=proof.benches)
    try:
        admin = first_admin(server)
        races.race(proof, server, admin, options.rounds, options.seed, lanes=4)
    finally:
        server.kill()


def main():
    options = settings()
    options.program = os.path.abspath(options.program)
    wanted = options.only.split(",")
    proof = Proof()
    folder = Folder()
    proof.say(f"{options.program}, seed {options.seed}, files in {folder.path}")
    postgres = None
    try:
        for part in (part for part in PARTS if part in wanted):
            proof.say(f"== {part}")
            if part == "burst":
                burst.run(proof, options, folder)
                continue
            part_folder = Folder()
            postgres = Postgres(part_folder)
            try:
                if part == "races":
                    run_races(proof, options, part_folder, postgres)
                elif part == "failures":
                    failures.run(proof, options, part_folder, postgres)
                else:
                    leases.run(proof, options, part_folder, postgres)
            finally:
                postgres.stop()
                if proof.findings or options.keep:
                    proof.say(f"logs are in {part_folder.path}")
                else:
                    part_folder.remove()
    finally:
        if not proof.findings and not options.keep:
            folder.remove()
    print()
    width = max((len(name) for name, _ in proof.figures), default=0)
    for name, value in proof.figures:
        print(f"{name:{width}}  {value}")
    print(f"\n{len(proof.findings)} promises broken in {time.monotonic() - proof.began:.0f} s")
    for text in proof.findings:
        print(f"  {text}")
    return 1 if proof.findings else 0


if __name__ == "__main__":
    sys.exit(main())
