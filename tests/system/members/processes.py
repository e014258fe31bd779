"""Processes that the proof starts and ends by their id: PostgreSQL, servers, a rig's agent."""

import os
import pwd
import re
import shutil
import signal
import subprocess
import tempfile
import time

PATIENCE_S = 120.0


def await_true(what, happened, patience_s=PATIENCE_S, every_s=0.02):
    """The first true value of happened(). The patience is a guard against hanging, so never a short one."""
    patience_s = max(patience_s, PATIENCE_S)
    until = time.monotonic() + patience_s
    while True:
        value = happened()
        if value:
            return value
        if time.monotonic() > until:
            raise TimeoutError(f"not within {patience_s:.0f} s: {what}")
        time.sleep(every_s)


class Folder:
    """A folder for everything that this proof writes; removed at the end, unless something failed."""

    def __init__(self):
        self.path = tempfile.mkdtemp(prefix="faultlab-members-")
        os.chmod(self.path, 0o755)

    def file(self, name):
        return os.path.join(self.path, name)

    def remove(self):
        shutil.rmtree(self.path, ignore_errors=True)


class Postgres:
    """A cluster of its own behind a socket in `folder`. PostgreSQL refuses to be root."""

    def __init__(self, folder):
        versions = "/usr/lib/postgresql"
        newest = max(os.listdir(versions), key=int)
        self.bin = f"{versions}/{newest}/bin"
        self.home = folder.file("postgres")
        os.mkdir(self.home)
        self.user = None
        if os.geteuid() == 0:
            self.user = "postgres"
            os.chown(self.home, pwd.getpwnam(self.user).pw_uid, -1)
        self._run("initdb", "--auth=trust", "--username=postgres", "--encoding=UTF8", "--locale=C")
        with open(f"{self.home}/data/postgresql.conf", "a", encoding="utf8") as settings:
            settings.write(
                f"listen_addresses=''\nunix_socket_directories='{self.home}'\n"
                "max_connections=100\nlog_line_prefix='%m [%p] %a '\n"
            )
        self.start()
        subprocess.run(
            [f"{self.bin}/createdb", "-h", self.home, "-U", "postgres", "lab"], check=True
        )
        self.url = f"postgresql://postgres@/lab?host={self.home}"

    def _run(self, program, *arguments):
        subprocess.run(
            [f"{self.bin}/{program}", "-D", f"{self.home}/data", *arguments],
            check=True,
            user=self.user,
            cwd="/",
            stdout=subprocess.DEVNULL,
        )

    def start(self):
        self._run("pg_ctl", "-s", "-w", "-l", f"{self.home}/log", "start")

    def stop(self):
        self._run("pg_ctl", "-s", "-w", "-m", "immediate", "stop")

    def restart(self):
        self._run("pg_ctl", "-s", "-w", "-l", f"{self.home}/log", "-m", "immediate", "restart")

    def ask(self, query):
        """For the report alone; the checks of the proof use the API."""
        done = subprocess.run(
            [f"{self.bin}/psql", "-h", self.home, "-U", "postgres", "-At", "-c", query, "lab"],
            check=True,
            capture_output=True,
            text=True,
        )
        return done.stdout.strip()


class Process:
    """A child with its log; SIGKILL at the end."""

    def __init__(self, command, log, environment=None):
        self.log = log
        with open(log, "ab") as out:
            self.child = subprocess.Popen(
                command,
                stdout=out,
                stderr=out,
                env={**os.environ, **(environment or {})},
                start_new_session=True,
            )

    def said(self):
        with open(self.log, encoding="utf8", errors="replace") as text:
            return text.read()

    def freeze(self):
        self.child.send_signal(signal.SIGSTOP)

    def wake(self):
        self.child.send_signal(signal.SIGCONT)

    def kill(self):
        self.child.kill()
        self.child.wait()

    def runs(self):
        return self.child.poll() is None


class Server(Process):
    """`faultlab serve` with settings of its own; the same name again is the same member again."""

    def __init__(self, program, folder, name, database="", benches=2, simulators=2, speed=20.0, **more):
        self.name = name
        self.starts = more.get("starts", 0)
        data = folder.file(f"data-{name}{more.get('suffix', '')}")
        settings = folder.file(f"{name}{more.get('suffix', '')}.toml")
        with open(settings, "w", encoding="utf8") as out:
            out.write(
                f'listen = "127.0.0.1:0"\ndata_dir = "{data}"\nserver_id = "{name}"\n{more.get("settings", "")}'
                f"[simulators]\ncount = {simulators}\nspeed = {speed}\n[lab]\nbenches = {benches}\n"
                f'[limits]\nruns = 64\npool_threads = 16\n{more.get("tables", "")}'
            )
            if database:
                out.write(f'[database]\nurl = "{database}"\n')
            if more.get("bus"):
                out.write(f'[lcm]\nurl = "{more["bus"]}"\nkeys = "{more["keys"]}"\n')
        log = folder.file(f"{name}{more.get('suffix', '')}.log")
        open(log, "wb").close()
        super().__init__([program, "serve", "--config", settings], log)
        self.port = 0
        if more.get("wait", True):
            self.await_port()

    def await_port(self):
        def port():
            if not self.runs():
                raise RuntimeError(f"server {self.name} has ended: {self.said()[-2000:]}")
            return re.search(r"listening on http://127\.0\.0\.1:(\d+)", self.said())

        self.port = int(await_true(f"server {self.name} listens", port).group(1))


class Agent(Process):
    """A simulated bench on the bus, as `faultlab rig` beside a real one."""

    def __init__(self, program, folder, name, bus):
        self.name = name
        super().__init__(
            [program, "rig", "--id", name, "--lcm", bus, "--keys", folder.file("keys"),
             "--state", folder.file("state"), "--no-supervisor"],
            folder.file(f"{name}.log"),
        )
