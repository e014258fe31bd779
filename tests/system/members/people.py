"""People who use a server by its published API: accounts, requests, the live view."""

import base64
import http.client
import json
import os
import re
import socket
import struct
import threading
import time

PASSWORD = "members-proof-1"


class Answer:
    def __init__(self, status, body, headers, seconds):
        self.status = status  # 0: no answer (refused, reset, or none in time)
        self.text = body
        self.headers = headers
        self.seconds = seconds
        self.at = time.monotonic()

    @property
    def ok(self):
        return 200 <= self.status < 300

    @property
    def body(self):
        try:
            return json.loads(self.text) if self.text else {}
        except ValueError:
            return {}

    def __str__(self):
        return f"{self.status} {self.text[:300]}"


def request(port, method, path, body=None, headers=None, patience_s=30.0):
    began = time.monotonic()
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=patience_s)
    try:
        content = body if body is None or isinstance(body, bytes) else json.dumps(body)
        sent = {"Content-Type": "application/json", **(headers or {})}
        connection.request(method, path, content, sent)
        answer = connection.getresponse()
        text = answer.read().decode("utf8", "replace")
        return Answer(answer.status, text, answer.headers, time.monotonic() - began)
    except (OSError, http.client.HTTPException) as error:
        return Answer(0, repr(error), {}, time.monotonic() - began)
    finally:
        connection.close()


class Person:
    """Signed in once; the cookie is good at every server of the database."""

    def __init__(self, port, login, more=None):
        """@param more  headers of every request of this person"""
        self.login = login
        answer = request(
            port, "POST", "/api/v1/auth/login", {"login": login, "password": PASSWORD}, more
        )
        if not answer.ok:
            raise RuntimeError(f"{login} cannot sign in: {answer}")
        self.headers = {
            "Cookie": next(
                cookie.split(";")[0]
                for cookie in answer.headers.get_all("Set-Cookie")
                if cookie.startswith("faultlab_session=")
            ),
            "X-CSRF-Token": answer.body["csrf_token"],
            **(more or {}),
        }

    def call(self, server, method, path, body=None, headers=None, patience_s=30.0):
        return request(
            server.port, method, "/api/v1/" + path, body, {**self.headers, **(headers or {})},
            patience_s,
        )

    def get(self, server, path, **more):
        return self.call(server, "GET", path, **more)

    def post(self, server, path, body=None, **more):
        return self.call(server, "POST", path, body or {}, **more)

    def delete(self, server, path, **more):
        return self.call(server, "DELETE", path, **more)

    def start_run(self, server, rig, seconds, **more):
        return self.post(server, "runs", {"rig": rig, "duration_s": seconds}, **more)


def first_admin(server):
    token = re.search(r"/reset\?token=([A-Za-z0-9_-]+)", server.said()).group(1)
    done = request(
        server.port, "POST", "/api/v1/auth/reset", {"token": token, "password": PASSWORD}
    )
    if not done.ok:
        raise RuntimeError(f"the first admin: {done}")
    return Person(server.port, "admin")


def new_person(server, admin, login, role="student"):
    made = admin.post(server, "users", {"login": login, "role": role})
    if made.status != 201:
        raise RuntimeError(f"{login}: {made}")
    link = admin.post(server, f"users/{made.body['id']}/reset-link")
    token = link.body["link"].split("token=")[1]
    request(server.port, "POST", "/api/v1/auth/reset", {"token": token, "password": PASSWORD})
    return Person(server.port, login)


class LiveView:
    """The WebSocket of one run: commands, and which of them were accepted when."""

    def __init__(self, server, person, run):
        self.sent = {}  # id of a command -> time of sending
        self.accepted = {}  # id -> time of its ack with ok
        self.refused = {}
        self.hello = threading.Event()
        self.epoch = 0
        self.open = False
        code = person.post(server, f"runs/{run}/stream-token")
        if code.status != 201:
            return
        self.socket = socket.create_connection(("127.0.0.1", server.port), timeout=30)
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(
            (
                f"GET /ws?code={code.body['code']} HTTP/1.1\r\nHost: 127.0.0.1\r\n"
                "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                f"Sec-WebSocket-Key: {key}\r\n\r\n"
            ).encode()
        )
        self.input = self.socket.makefile("rb")
        status = self.input.readline()
        while self.input.readline() not in (b"\r\n", b""):
            pass
        self.open = b"101" in status
        self.reader = threading.Thread(target=self._read, daemon=True)
        if self.open:
            self.reader.start()
            self.hello.wait(120)

    def _read(self):
        try:
            while True:
                head = self.input.read(2)
                if len(head) < 2:
                    break
                size = head[1] & 127
                if size == 126:
                    size = struct.unpack(">H", self.input.read(2))[0]
                elif size == 127:
                    size = struct.unpack(">Q", self.input.read(8))[0]
                payload = self.input.read(size)
                kind = head[0] & 15
                if kind == 1:
                    self._hear(json.loads(payload))
                elif kind == 2:
                    self._rows(payload)
                elif kind == 9:
                    self._send(10, payload)  # a view that is silent for 45 s is closed
                elif kind == 8:
                    break
        except (OSError, ValueError):
            pass
        self.open = False

    def _hear(self, message):
        if message["type"] == "hello":
            self.epoch = message["epoch"]
            self.hello.set()
        elif message["type"] == "ack":
            (self.accepted if message["ok"] else self.refused)[message["id"]] = time.monotonic()

    def _rows(self, payload):
        """Samples: a subclass may keep them."""

    def _send(self, kind, payload):
        mask = os.urandom(4)
        body = bytes(b ^ mask[i % 4] for i, b in enumerate(payload))
        size = len(payload)
        head = bytes([0x80 | size]) if size < 126 else bytes([0x80 | 126]) + struct.pack(">H", size)
        self.socket.sendall(bytes([0x80 | kind]) + head + mask + body)

    def command(self, value=100.0):
        """Sends a change of R1. @returns its id, None when the socket is closed"""
        number = str(len(self.sent) + 1)
        text = json.dumps(
            {"type": "command", "epoch": self.epoch, "id": number, "action": "set",
             "component": "R1", "value": value}
        ).encode()
        self.sent[number] = time.monotonic()
        try:
            self._send(1, text)
        except OSError:
            self.open = False
            return None
        return number

    def close(self):
        try:
            self.socket.shutdown(socket.SHUT_RDWR)
            self.socket.close()
        except (AttributeError, OSError):
            pass
