"""`cmake --install` of each component into a folder of its own: what is there, and that the agent needs none of the
server's libraries.

  install_proof.py --cmake PROGRAM --build DIR
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile

BOTH = ("share/{0}/benches/paper.toml", "share/doc/{0}/LICENSE", "share/doc/{0}/deploy/THIRD_PARTY.md",
        "lib/systemd/system/{0}.service", "bin/{0}")
WANTED = {
    "server": ("faultlab", ("sbin/faultlab-backup", "sbin/faultlab-restore", "share/doc/faultlab/README.md",
                            "share/doc/faultlab/examples/config.example.toml", "share/doc/faultlab/examples/client.py")),
    "agent": ("faultlab-rig", ("share/doc/faultlab-rig/hardware/KIT.md", "share/doc/faultlab-rig/examples/rig.env")),
}
# Of the agent: LCM, libsodium and what every C++ program has (and the sanitizers).
AGENT_NEEDS = re.compile(r"lib(lcm|sodium|stdc\+\+|m|gcc_s|c|asan|ubsan)\.so|ld-linux")


def check(true, what):
    if not true:
        sys.exit(what)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cmake", required=True)
    parser.add_argument("--build", required=True)
    options = parser.parse_args()
    for component, (package, more) in WANTED.items():
        with tempfile.TemporaryDirectory() as prefix:
            subprocess.run([options.cmake, "--install", options.build, "--prefix", prefix, "--component", component],
                           check=True, stdout=subprocess.PIPE)
            for name in (*(each.format(package) for each in BOTH), *more):
                check(os.path.getsize(os.path.join(prefix, name)) > 0, f"{component}: {name} is empty")
            check(len(os.listdir(os.path.join(prefix, "bin"))) == 1, f"{component}: {os.listdir(prefix + '/bin')}")
            with open(f"{prefix}/lib/systemd/system/{package}.service", encoding="utf-8") as file:
                program = re.search(r"^ExecStart=(\S+)", file.read(), re.M).group(1)
            check(program == f"{prefix}/bin/{package}", f"{component}: its unit starts {program}")
            said = subprocess.run([program, "--version"], check=True, stdout=subprocess.PIPE, text=True).stdout
            check(said.startswith(package + " "), said)
            if component == "agent":
                named = re.findall(r"NEEDED.*\[(.*)\]", subprocess.run(
                    ["readelf", "-d", program], check=True, stdout=subprocess.PIPE, text=True).stdout)
                others = [name for name in named if not AGENT_NEEDS.match(name)]
                check(named and not others, f"the agent needs {others}")
    print("both components are whole")


if __name__ == "__main__":
    main()
