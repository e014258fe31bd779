"""A faultlab server from Python: one file, the standard library alone.

    from faultlab import Lab

    lab = Lab("http://127.0.0.1:8080", key="flk_..")  # the page, "Account", makes keys
    for component, value in (("R1", 100), ("C8", 4.7e-6), ("R12", 2200)):
        run = lab.run(faults=[{"component": component, "value": value, "at_s": 10}], duration_s=20)
        print(component, value, "->", *run.found())

A bench is used in a session: `with lab.session("bench") as rig: rig.run(..)`. Many runs are one request:
`batch = lab.jobs([{"duration_s": 20}, ..]); batch.wait(); batch.results()`. With pytest, `from faultlab import rig` is a
fixture of a bench, or of simulators where FAULTLAB_RIG is not set; FAULTLAB_URL and FAULTLAB_KEY say which lab.
"""

import csv
import http.client
import io
import json
import os
import time
import urllib.parse
import uuid

WAIT_S = 20  # of one request; the server's most is 60


class Refused(Exception):
    """What the server answered: `status`, `reason` (a word for programs), `detail` (a sentence), `field`."""

    def __init__(self, status, problem):
        self.status = status
        self.reason = problem.get("reason", "")
        self.detail = problem.get("detail", "")
        self.field = problem.get("field", "")
        super().__init__(f"{status} {self.reason}: {self.detail} {self.field}".strip())


class Lab:
    def __init__(self, url="http://127.0.0.1:8080", key=None, patience_s=60.0):
        """@param key  None: as a guest, where the lab lets guests in
        @param patience_s  for a server that is away or busy"""
        parts = urllib.parse.urlsplit(url)
        self._https = parts.scheme == "https"
        self._host = parts.netloc
        self._key = key
        self._patience_s = patience_s

    def ask(self, method, path, body=None):
        """The bytes of an answer of /api/v1/. A POST is sent again with the same Idempotency-Key, so that it is done
        once; busy and away are waited for."""
        headers = {"Accept": "*/*"}
        if self._key:
            headers["Authorization"] = f"Bearer {self._key}"
        if method == "POST" and self._key:
            headers["Idempotency-Key"] = str(uuid.uuid4())
        if body is not None:
            body = json.dumps(body)
            headers["Content-Type"] = "application/json"
        until = time.monotonic() + self._patience_s
        while True:
            try:
                status, answer, after_s = self._send(method, path, body, headers)
            except (OSError, http.client.HTTPException):
                if time.monotonic() > until or (method == "POST" and not self._key):
                    raise
                time.sleep(1)
                continue
            if status < 400:
                return answer
            again = status in (429, 503) or (status in (502, 504) and (method == "GET" or self._key))
            if not again or time.monotonic() + after_s > until:
                raise Refused(status, json.loads(answer) if answer.startswith(b"{") else {})
            time.sleep(after_s)

    def _send(self, method, path, body, headers):
        kind = http.client.HTTPSConnection if self._https else http.client.HTTPConnection
        connection = kind(self._host, timeout=WAIT_S + 30)
        try:
            connection.request(method, "/api/v1/" + path, body, headers)
            answer = connection.getresponse()
            return answer.status, answer.read(), float(answer.headers.get("Retry-After", 1))
        finally:
            connection.close()

    def watch(self, path, settled):
        """What a path tells once it is settled; the server answers when it is, or after WAIT_S."""
        while True:
            began = time.monotonic()
            told = self.get(path, wait=WAIT_S)
            if settled(told):
                return told
            time.sleep(max(0.0, began + 1 - time.monotonic()))  # where it had no room to let us wait

    def get(self, path, **query):
        text = self.ask("GET", path + ("?" + urllib.parse.urlencode(query) if query else ""))
        return json.loads(text) if text else {}

    def post(self, path, body=None):
        text = self.ask("POST", path, {} if body is None else body)
        return json.loads(text) if text else {}

    def run(self, **plan):
        """Plays a plan (POST runs) and waits for its end."""
        return Run(self, self.post("runs", plan)["id"]).wait()

    def jobs(self, runs, name=""):
        """Plays many plans without a person, simulated ones as fast as the server can."""
        return Batch(self, self.post("jobs", {"runs": list(runs), "name": name})["batch"])

    def session(self, rig_class, minutes=30):
        return Session(self, rig_class, minutes)


class Run:
    """An experiment: `data` is what the server tells of it, see GET runs/ID in its API reference."""

    def __init__(self, lab, id):
        self.lab = lab
        self.id = id
        self.data = {}

    def wait(self):
        self.data = self.lab.watch(f"runs/{self.id}", lambda run: run["state"] != "running")
        return self

    def diagnosis(self):
        """What the server found, as `faultlab diagnose --json` tells it."""
        return self.lab.get(f"runs/{self.id}/diagnosis")

    def found(self):
        """(component, value, standard error) of the likeliest candidate; Nones where there is none."""
        candidates = self.diagnosis()["candidates"] or [{}]
        return tuple(candidates[0].get(name) for name in ("component", "value", "sigma"))

    def csv(self):
        return self.lab.ask("GET", f"runs/{self.id}/export.csv")

    def samples(self):
        """A list of dictionaries, the columns of the CSV as numbers."""
        text = self.csv().decode("utf8")
        lines = [line for line in text.splitlines() if line and not line.startswith("#")]
        return [
            {name: float(value) if value else None for name, value in row.items()}
            for row in csv.DictReader(io.StringIO("\n".join(lines)))
        ]


class Batch:
    def __init__(self, lab, id):
        self.lab = lab
        self.id = id

    def state(self):
        return self.lab.get(f"jobs/batches/{self.id}")

    def wait(self):
        self.lab.watch(f"jobs/batches/{self.id}", lambda batch: batch["ended_at"] is not None)
        return self

    def cancel(self):
        try:
            self.lab.ask("DELETE", f"jobs/batches/{self.id}")
        except Refused as refused:
            if refused.reason != "job_ended":
                raise

    def results(self):
        """Of each job what became of it: run, component, value, named, found, delay_s."""
        text = self.lab.ask("GET", f"jobs/batches/{self.id}/jobs.jsonl").decode("utf8")
        return [json.loads(line) for line in text.splitlines()]


class Session:
    """A bench from its offer to its end: `with lab.session("bench") as rig`."""

    def __init__(self, lab, rig_class, minutes):
        self.lab = lab
        self.rig_class = rig_class
        self.minutes = minutes
        self.id = None
        self.rig = None
        self._own = False

    def __enter__(self):
        """The session that one has already, as of a booking that is claimed, is used and goes on afterwards."""
        want_s = int(self.minutes * 60)
        asked = self.lab.post("tickets", {"rig_class": self.rig_class, "want_s": want_s, "min_s": min(600, want_s)})
        session = asked.get("session")
        if session is None:
            session = self._accepted(asked["ticket"]["id"])
            self._own = True
        self.id, self.rig = session["id"], session["rig"]
        return self

    def _accepted(self, ticket):
        def offer(tickets):
            return next((each for each in tickets["items"] if each["id"] == ticket), None)

        try:
            told = self.lab.watch("tickets", lambda each: (offer(each) or {}).get("state") != "waiting")
            if offer(told) is None:
                raise Refused(409, {"reason": "offer_gone", "detail": "The offer of a rig was not taken in time."})
            return self.lab.post(f"tickets/{ticket}/accept")
        except BaseException:
            try:
                self.lab.post(f"tickets/{ticket}/leave")
            except Refused:
                pass
            raise

    def run(self, **plan):
        return self.lab.run(rig=self.rig, **plan)

    def __exit__(self, *_):
        if not self._own:
            return
        try:
            self.lab.post(f"sessions/{self.id}/end")
        except Refused as refused:
            if refused.status != 404:  # it has ended by itself
                raise


class Simulators:
    """As a session, of simulators: everybody has them at once."""

    def __init__(self, lab):
        self.lab = lab

    def run(self, **plan):
        return self.lab.run(**plan)


def _from_environment():
    return Lab(os.environ.get("FAULTLAB_URL", "http://127.0.0.1:8080"), os.environ.get("FAULTLAB_KEY"))


try:
    import pytest
except ImportError:
    pass
else:

    @pytest.fixture
    def rig():
        """A bench of the class FAULTLAB_RIG for one test, or simulators."""
        lab = _from_environment()
        if "FAULTLAB_RIG" not in os.environ:
            yield Simulators(lab)
            return
        with lab.session(os.environ["FAULTLAB_RIG"]) as bench:
            yield bench
