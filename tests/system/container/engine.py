"""Podman with storage and settings of its own, and images made of Debian packages instead of fetched ones."""

import glob
import os
import re
import resource
import shutil
import subprocess

CERTIFICATES = "/usr/local/share/machine/certificates.crt"
POSTGRES = """FROM docker.io/library/debian:12
RUN apt-get update && apt-get install -y --no-install-recommends postgresql-15
COPY postgres-entrypoint /usr/local/bin/
VOLUME /var/lib/postgresql/data
ENTRYPOINT ["/usr/local/bin/postgres-entrypoint"]
"""
# The features of the official image that faultlab's compose file uses: user, password file,
# database, a kept folder.
POSTGRES_ENTRYPOINT = """#!/bin/sh
set -eu
data=/var/lib/postgresql/data
bin=/usr/lib/postgresql/15/bin
install -d -o postgres -m 0700 $data
install -d -o postgres /var/run/postgresql
install -o postgres -m 0400 "$POSTGRES_PASSWORD_FILE" /tmp/password
as() { setpriv --reuid postgres --regid postgres --init-groups "$@"; }
if [ ! -s $data/PG_VERSION ]; then
  as $bin/initdb -D $data -U "$POSTGRES_USER" --pwfile=/tmp/password --auth=scram-sha-256 >/dev/null
  echo "host all all all scram-sha-256" >>$data/pg_hba.conf
  echo "CREATE DATABASE $POSTGRES_DB" | as $bin/postgres --single -D $data postgres >/dev/null
fi
rm -f /tmp/password
exec setpriv --reuid postgres --regid postgres --init-groups $bin/postgres -D $data -c "listen_addresses=*"
"""
CADDY = """FROM docker.io/library/debian:12
RUN apt-get update && apt-get install -y --no-install-recommends caddy
ENV XDG_DATA_HOME=/data XDG_CONFIG_HOME=/config
CMD ["caddy", "run", "--config", "/etc/caddy/Caddyfile", "--adapter", "caddyfile"]
"""


class Engine:
    def __init__(self, folder):
        self.folder = folder
        self.environment = {**os.environ, **self._settings()}

    def _settings(self):
        def write(name, text):
            path = os.path.join(self.folder, name)
            with open(path, "w", encoding="utf8") as out:
                out.write(text)
            return path

        runtime = "runc" if shutil.which("runc") else "crun"
        # Podman's default limits may exceed those of the machine.
        limits = [
            f'"{name}={min(resource.getrlimit(kind)[1], most)}:{min(resource.getrlimit(kind)[1], most)}"'
            for name, kind, most in [
                ("nofile", resource.RLIMIT_NOFILE, 16384),
                ("nproc", resource.RLIMIT_NPROC, 16384),
            ]
        ]
        return {
            "CONTAINERS_CONF": write(
                "containers.conf",
                f'[containers]\ndefault_ulimits = [{", ".join(limits)}]\n'
                f'[engine]\nruntime = "{runtime}"\ncgroup_manager = "cgroupfs"\nevents_logger = "file"\n'
                f'[network]\nnetwork_backend = "netavark"\nnetwork_config_dir = "{self.folder}/networks"\n',
            ),
            "CONTAINERS_STORAGE_CONF": write(
                "storage.conf",
                f'[storage]\ndriver = "overlay"\ngraphroot = "{self.folder}/storage"\n'
                f'runroot = "{self.folder}/run"\n',
            ),
        }

    def call(self, *command, cwd=None, check=True, input_text=None, quiet=True):
        done = subprocess.run(
            command,
            cwd=cwd,
            env=self.environment,
            input=input_text,
            text=True,
            stdout=subprocess.PIPE if quiet else None,
            stderr=subprocess.STDOUT if quiet else None,
            check=False,
        )
        if check and done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)[:200]}: exit {done.returncode}\n{(done.stdout or '')[-3000:]}")
        return (done.stdout or "").strip()

    def podman(self, *arguments, **more):
        return self.call("podman", *arguments, **more)

    def make_base_images(self):
        """debian:12 and debian:12-slim: a bare Debian with this machine's mirror, registry and certificates."""
        root = os.path.join(self.folder, "debian")
        self.call("debootstrap", "--variant=minbase", "bookworm", root, mirror())
        # Under names of their own, because installing ca-certificates rewrites its bundle.
        for source, target in [
            ("/etc/apt/sources.list.d/debian.sources", "/etc/apt/sources.list.d/debian.sources"),
            ("/etc/ssl/certs/ca-certificates.crt", CERTIFICATES),
        ]:
            if os.path.exists(source):
                os.makedirs(os.path.dirname(root + target), exist_ok=True)
                shutil.copy(source, root + target)
        if os.path.exists(root + "/etc/apt/sources.list.d/debian.sources"):
            with open(root + "/etc/apt/sources.list", "w", encoding="utf8"):
                pass
        for source in glob.glob("/etc/apt/apt.conf.d/*"):
            with open(source, encoding="utf8") as text:
                settings = text.read()
            if re.search(r"^ *Acquire::", settings, re.M) and not re.search("password|login|netrc", settings, re.I):
                shutil.copy(source, root + "/etc/apt/apt.conf.d/")
        if shutil.which("npm"):
            registry = next(
                line for line in self.call("npm", "config", "get", "registry").splitlines() if line.startswith("http")
            )
            with open(root + "/root/.npmrc", "w", encoding="utf8") as out:
                out.write(f"registry={registry}\ncafile={CERTIFICATES}\n")
        archive = os.path.join(self.folder, "debian.tar")
        self.call("tar", "-C", root, "-cf", archive, ".")
        shutil.rmtree(root)
        for tag in ["12", "12-slim"]:
            self.podman("import", archive, f"docker.io/library/debian:{tag}")
        os.remove(archive)

    def make_image(self, name, text, files=()):
        folder = os.path.join(self.folder, re.sub(r"\W", "-", name))
        os.mkdir(folder)
        for file, content in [("Dockerfile", text), *files]:
            path = os.path.join(folder, file)
            with open(path, "w", encoding="utf8") as out:
                out.write(content)
            os.chmod(path, 0o755)
        self.podman("build", "--pull=never", "--network=host", "-t", name, folder)

    def make_stand_ins(self):
        self.make_image(
            "docker.io/library/postgres:15", POSTGRES, [("postgres-entrypoint", POSTGRES_ENTRYPOINT)]
        )
        self.make_image("docker.io/library/caddy:2", CADDY)


def mirror():
    for path, pattern in [
        ("/etc/apt/sources.list.d/debian.sources", r"^URIs: *(\S+)"),
        ("/etc/apt/sources.list", r"^deb +(?:\[.*?\] +)?(\S+)"),
    ]:
        if os.path.exists(path):
            with open(path, encoding="utf8") as text:
                found = re.search(pattern, text.read(), re.M)
            if found:
                return found.group(1)
    raise RuntimeError("no apt mirror found on this machine")
