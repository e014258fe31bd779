"""deploy/Dockerfile and deploy/compose.yaml, built and used as their comments say."""

import argparse
import http.client
import json
import os
import re
import shutil
import ssl
import subprocess
import sys
import tempfile
import time

import yaml
from engine import Engine

HERE = os.path.dirname(os.path.abspath(__file__))
PROJECT = os.path.abspath(os.path.join(HERE, "..", "..", ".."))
PASSWORD = "container-proof-1"


class Browser:
    """Speaks HTTPS to the proxy, as people do."""

    def __init__(self):
        self.headers = {}

    def call(self, method, path, body=None, more=None):
        connection = http.client.HTTPSConnection(
            "localhost", 443, timeout=20, context=ssl._create_unverified_context()
        )
        try:
            sent = {"Content-Type": "application/json", **self.headers, **(more or {})}
            connection.request(method, path, None if body is None else json.dumps(body), sent)
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read().decode("utf8", "replace")
        finally:
            connection.close()

    def api(self, method, path, body=None, more=None):
        status, _, text = self.call(method, "/api/v1/" + path, body, more)
        if status >= 300:
            raise RuntimeError(f"{method} {path}: {status} {text[:300]}")
        return json.loads(text) if text else {}

    def sign_in(self, login):
        status, headers, text = self.call(
            "POST", "/api/v1/auth/login", {"login": login, "password": PASSWORD}
        )
        if status != 200:
            raise RuntimeError(f"sign-in: {status} {text}")
        cookie = next(c for c in headers.get_all("Set-Cookie") if "faultlab_session" in c)
        if "Secure" not in cookie:
            raise RuntimeError(f"behind TLS the cookie is not Secure: {cookie}")
        self.headers = {"Cookie": cookie.split(";")[0], "X-CSRF-Token": json.loads(text)["csrf_token"]}


class Lab:
    def __init__(self, engine, checkout):
        self.engine = engine
        self.folder = os.path.join(checkout, "deploy")

    def compose(self, *arguments, **more):
        return self.engine.call("podman-compose", "-f", "compose.yaml", *arguments, cwd=self.folder, **more)

    def make_networks(self):
        """As compose.yaml says: podman-compose 1.0 does not read `ipam`."""
        with open(os.path.join(self.folder, "compose.yaml"), encoding="utf8") as text:
            networks = yaml.safe_load(text)["networks"]
        for name, about in networks.items():
            arguments = ["--internal"] if about.get("internal") else []
            for each in about.get("ipam", {}).get("config", []):
                arguments += ["--subnet", each["subnet"]]
            self.engine.podman("network", "create", *arguments, f"deploy_{name}")

    def container(self, service):
        names = self.engine.podman("ps", "-a", "--format", "{{.Names}}").split()
        return next(name for name in names if service in name)

    def inside(self, service, *command, check=True):
        return self.engine.podman("exec", self.container(service), *command, check=check)

    def said(self, service="lab"):
        return self.engine.podman("logs", self.container(service), check=False)


def await_true(what, happened, patience_s=90.0):
    until = time.monotonic() + patience_s
    while time.monotonic() < until:
        try:
            value = happened()
            if value:
                return value
        except (OSError, RuntimeError, http.client.HTTPException):
            pass
        time.sleep(0.5)
    raise TimeoutError(f"not within {patience_s:.0f} s: {what}")


def check(what, true, seen=""):
    if not true:
        raise RuntimeError(f"{what}: {seen}")
    print(f"  {what}", flush=True)


def check_service(lab, browser):
    status, headers, text = browser.call("GET", "/")
    check("the page comes through the proxy", status == 200 and "<html" in text, f"{status} {text[:200]}")
    check("HSTS is set behind TLS", "Strict-Transport-Security" in headers, dict(headers))
    token = re.search(r"/reset\?token=([A-Za-z0-9_-]+)", lab.said()).group(1)
    browser.api("POST", "auth/reset", {"token": token, "password": PASSWORD})
    browser.call("POST", "/api/v1/auth/login", {"login": "admin", "password": "wrong"}, {"X-Forwarded-For": "192.0.2.99"})
    browser.sign_in("admin")
    status, _, text = browser.call("GET", "/readyz")
    check("the server is ready", status == 200, f"{status} {text}")
    audit = json.dumps(browser.api("GET", "audit"))
    check("an address that the client made up is not believed", "192.0.2.99" not in audit, audit[:600])


def check_confinement(lab):
    lab_id = lab.inside("lab", "id", "-u")
    check("the server is not root", lab_id == "999", lab_id)
    status = lab.inside("lab", "sh", "-c", "cat /proc/1/status")
    check("it has no capability", re.search(r"CapEff:\s*0+$", status, re.M), status)
    check("it gains no privileges", re.search(r"NoNewPrivs:\s*1", status), status)
    writes = lab.inside("lab", "sh", "-c", "touch /usr/x 2>&1", check=False)
    check("its root is read-only", "Read-only" in writes, writes)
    modes = lab.inside("lab", "sh", "-c", "stat -c '%a %U %n' /data /data/*")
    loose = [line for line in modes.splitlines() if not re.match(r"[67]00 faultlab ", line)]
    check("its data are its own", not loose, modes)
    reach = "timeout 3 bash -c '</dev/tcp/database/5432' 2>&1 && echo reached"
    check("the server reaches the database", "reached" in lab.inside("lab", "bash", "-c", reach, check=False))
    check("the proxy does not", "reached" not in lab.inside("proxy", "bash", "-c", reach, check=False))


def check_work(lab, browser):
    run = browser.api("POST", "runs", {"duration_s": 6})["id"]
    ended = await_true(
        "the run has ended", lambda: (r := browser.api("GET", f"runs/{run}"))["state"] != "running" and r
    )
    check("a run is recorded", ended["state"] == "finished" and ended["samples"] == 600, ended)
    going = browser.api("POST", "runs", {"duration_s": 600})["id"]
    began = time.monotonic()
    lab.engine.podman("stop", "-t", "15", lab.container("lab"))
    took = time.monotonic() - began
    check(f"it ends when asked ({took:.1f} s)", took < 14, took)
    lab.engine.podman("start", lab.container("lab"))
    await_true("ready again", lambda: browser.call("GET", "/healthz")[0] == 200)
    kept = browser.api("GET", f"runs/{run}")
    check("records are kept", kept["samples"] == 600, kept)
    left = browser.api("GET", f"runs/{going}")
    check("the run that was under way has ended", left["state"] not in ("running", "starting"), left)


def build_images(engine, checkout):
    began = time.monotonic()
    engine.make_base_images()
    engine.make_stand_ins()
    print(f"base images: {time.monotonic() - began:.0f} s", flush=True)
    began = time.monotonic()
    # podman-compose gives this name to the image of the service "lab" of the folder "deploy".
    engine.podman(
        "build", "--pull=never", "--network=host", "-f", "deploy/Dockerfile", "-t", "deploy_lab", ".", cwd=checkout
    )
    size = engine.podman("image", "inspect", "--format", "{{.Size}}", "deploy_lab")
    print(f"deploy/Dockerfile: {time.monotonic() - began:.0f} s, {int(size) >> 20} MB", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--keep", action="store_true", help="leave the containers for looking at")
    parser.add_argument("--built", metavar="FOLDER", help="with the images of a run that was kept")
    options = parser.parse_args()
    if os.geteuid() != 0:
        sys.exit("tests/system/container/run: needs root, as debootstrap and Podman's networks do")
    folder = options.built or tempfile.mkdtemp(
        prefix="faultlab-container-", dir=os.environ.get("TMPDIR", "/var/tmp")
    )
    engine = Engine(folder)
    checkout = os.path.join(folder, "checkout")
    os.makedirs(checkout, exist_ok=True)
    archive = subprocess.run(["git", "-C", PROJECT, "archive", "HEAD"], check=True, capture_output=True).stdout
    subprocess.run(["tar", "-C", checkout, "-xf", "-"], input=archive, check=True)
    lab = Lab(engine, checkout)
    engine.environment["LAB_NAME"] = "localhost"
    failed = None
    try:
        if not options.built:
            build_images(engine, checkout)
        once = re.search(r"cd deploy && (umask.*?chown 999 pgpass)", without_marks(lab.folder), re.S).group(1)
        engine.call("sh", "-c", once, cwd=lab.folder)
        lab.make_networks()
        lab.compose("up", "-d", "--no-build")
        browser = Browser()
        await_true("the page", lambda: browser.call("GET", "/healthz")[0] == 200)
        check_service(lab, browser)
        check_confinement(lab)
        check_work(lab, browser)
    except Exception as error:  # noqa: BLE001
        failed = error
        for service in ["database", "lab", "proxy"]:
            try:
                print(f"--- {service}\n{lab.said(service)[-1500:]}")
            except (StopIteration, RuntimeError):
                print(f"--- {service}: no container")
    if options.keep:
        print(f"kept: {folder}")
    else:
        lab.compose("down", "-v", check=False)
        engine.podman("system", "reset", "--force", check=False)
        shutil.rmtree(folder, ignore_errors=True)
    if failed:
        print(f"FOUND: {failed}")
        return 1
    print("container: nothing found")
    return 0


def without_marks(folder):
    """compose.yaml's opening comment as one text."""
    with open(os.path.join(folder, "compose.yaml"), encoding="utf8") as text:
        lines = [line[1:].strip() for line in text if line.startswith("#")]
    return " ".join(lines)


if __name__ == "__main__":
    sys.exit(main())
