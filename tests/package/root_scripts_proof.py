"""faultlab-backup and faultlab-restore run as root in folders that the server's user owns, and may have prepared. What
they do there they do as that user: every tool that root itself calls is written down, and names are planted.

  root_scripts_proof.py --deploy FOLDER
"""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

TOOLS = ("cat", "chmod", "chown", "cp", "find", "install", "ln", "mkdir", "mktemp", "mv", "rm", "rmdir", "touch",
         "xargs")
STUB = """#!/bin/sh
[ -n "${AS_SERVER:-}" ] || echo "TOOL $*" >>"$BY_ROOT"
exec "$(PATH=/usr/bin:/bin command -v TOOL)" "$@"
"""
PROGRAM = """#!/bin/sh
[ -n "${AS_SERVER:-}" ] || echo "faultlab $*" >>"$BY_ROOT"
case "$1 $2" in
  "admin backup") echo new >"$3" ;;
  "admin restore") [ "${REFUSES:-}" = 1 ] && exit 3; exec cp "$3" "$5/faultlab.db" ;;
esac
"""


class World:
    """The scripts with folders of their own, and stubs in the place of every tool that changes files."""

    def __init__(self, folder, deploy):
        self.data, self.backups, self.bin = folder / "data", folder / "backups", folder / "bin"
        for each in (self.data, self.backups, self.bin):
            each.mkdir()
        self.by_root = folder / "by_root"
        for tool in TOOLS:
            self.program(tool, STUB.replace("TOOL", tool))
        self.program("faultlab", PROGRAM)
        self.program("runuser", '#!/bin/sh\nshift 3\nAS_SERVER=1 exec "$@"\n')
        self.program("systemctl", "#!/bin/sh\n")
        self.program("dpkg-query", "#!/bin/sh\necho 1.0\n")
        self.script = {}
        for name in ("faultlab-backup", "faultlab-restore"):
            text = (deploy / name).read_text(encoding="utf-8")
            for path, own in (("/var/lib/faultlab", self.data), ("/var/backups/faultlab", self.backups),
                              ("-o faultlab -g faultlab ", "")):
                text = text.replace(path, str(own))
            self.script[name] = self.program(name, text)

    def program(self, name, text):
        path = self.bin / name
        path.write_text(text, encoding="utf-8")
        path.chmod(0o755)
        return path

    def run(self, name, *words, **more):
        self.by_root.write_text("", encoding="utf-8")
        env = {**os.environ, "PATH": f"{self.bin}:{os.environ['PATH']}", "BY_ROOT": str(self.by_root), **more}
        done = subprocess.run([self.script[name], *words], env=env, cwd=self.backups.parent, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        return done, self.by_root.read_text(encoding="utf-8").splitlines()


def check(true, what):
    if not true:
        sys.exit(what)


def backup(world):
    (world.data / "faultlab.db").write_text("old")
    victim = world.backups.parent / "victim"
    victim.write_text("of somebody else")
    for name in ("20 victim Z-", "20\nvictim\nZ-", "20-rf victim Z-", "20260101T000000Z-1"):
        (world.backups / name).write_text("planted")
    done, by_root = world.run("faultlab-backup", "--keep", "1")
    check(done.returncode == 0, done.stdout)
    left = sorted(os.listdir(world.backups))
    check(len(left) == 1 and left[0].endswith("-1.0.db"), f"the newest is kept: {left}")
    check(victim.exists(), "a name with spaces was taken for several")
    check(by_root == [f"install -d -m 0700 {world.backups}"], f"root touches the server's files: {by_root}")


def restore(world):
    given = world.backups.parent / "given.db"
    given.write_text("new")
    database = world.data / "faultlab.db"
    database.write_text("old")
    # Whatever root wrote through would be changed.
    precious = world.backups.parent / "precious"
    precious.mkdir()
    for name in ("restored.part", "faultlab.db-wal", "replaced-"):
        (world.data / name).symlink_to(precious)
    done, by_root = world.run("faultlab-restore", str(given), REFUSES="1")
    check(done.returncode == 3 and database.read_text() == "old", f"nothing is changed: {done.stdout}")
    check(by_root == [], f"root touches the server's files: {by_root}")
    done, by_root = world.run("faultlab-restore", str(given))
    check(done.returncode == 0 and database.read_text() == "new", done.stdout)
    check(by_root == [], f"root touches the server's files: {by_root}")
    kept = list(world.data.glob("replaced-*/faultlab.db"))
    check(len(kept) == 1 and kept[0].read_text() == "old", f"what was replaced is kept: {kept}")
    check(os.listdir(precious) == [], "a planted link was followed")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--deploy", required=True, type=pathlib.Path)
    options = parser.parse_args()
    for proof in (backup, restore):
        with tempfile.TemporaryDirectory() as folder:
            proof(World(pathlib.Path(folder), options.deploy))
    print("root touches nothing that the server's user owns")


if __name__ == "__main__":
    main()
