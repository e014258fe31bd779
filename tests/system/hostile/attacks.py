"""What somebody does who wants the server to fall over. Each attack is a thread that goes on until told to stop."""

import gzip
import json
import socket
import threading

ROWS = 250_000  # of an upload: 42 min at 100 Hz, 14 MB


def recording(rows=ROWS):
    lines = ["t_s,uc_v,um_v"]
    lines += [f"{k / 100:.2f},{2 + (k // 50) % 2},{0.1 + (k % 97) / 100:.4f}" for k in range(rows)]
    return ("\n".join(lines) + "\n").encode()


class Attack(threading.Thread):
    """Counts what it got as answers, by status."""

    def __init__(self, name, world, places=1):
        super().__init__(name=name, daemon=True)
        self.world = world
        self.places = places
        self.answers = {}
        self.over = threading.Event()

    def count(self, status):
        self.answers[status] = self.answers.get(status, 0) + 1

    def stop(self):
        self.over.set()

    def run(self):
        while not self.over.is_set():
            try:
                self.attack()
            except OSError:
                self.count("closed")
            self.over.wait(0.02)

    def attack(self):
        raise NotImplementedError

    def connect(self, receive_bytes=None):
        sock = socket.socket()
        if receive_bytes:
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_bytes)
        sock.settimeout(5)
        sock.connect(("127.0.0.1", self.world.port))
        return sock

    def head(self, method, path, more=""):
        return (
            f"{method} {path} HTTP/1.1\r\nHost: localhost\r\nX-Forwarded-For: {self.world.enemy}\r\n{more}\r\n"
        ).encode()


def status_of(data):
    return int(data[9:12]) if data.startswith(b"HTTP/1.1 ") else "closed"


class Unread(Attack):
    """Asks for large answers on many connections and reads none of them."""

    def __init__(self, world, path, places):
        super().__init__(f"{places} unread {path.rsplit('/', 1)[1]}", world, places)
        self.path = path
        self.open = []

    def attack(self):
        for sock in self.open:
            try:
                sock.setblocking(False)
                data = sock.recv(16)
                if data:
                    self.count(status_of(data))
            except BlockingIOError:
                continue
            except OSError:
                pass
        while len(self.open) < self.places and not self.over.is_set():
            sock = self.connect(receive_bytes=4096)
            sock.sendall(self.head("GET", self.path))
            self.open.append(sock)
        self.over.wait(3)
        for sock in self.open[: self.places // 2]:
            sock.close()
        self.open = self.open[self.places // 2 :]


class HalfUploads(Attack):
    """Uploads whose last byte never comes."""

    def attack(self):
        size = 20 << 20
        piece = b"0" * (1 << 20)
        open_now = []
        for _ in range(self.places):
            if self.over.is_set():
                break
            sock = self.connect()
            sock.settimeout(0.5)
            open_now.append(sock)
            try:
                sock.sendall(
                    self.head(
                        "POST",
                        "/api/v1/recordings",
                        f"Content-Type: text/csv\r\nContent-Length: {size}\r\n",
                    )
                )
                for _ in range(19):
                    sock.sendall(piece)
            except OSError:
                pass
            try:
                self.count(status_of(sock.recv(16)))
            except OSError:
                self.count("held")
        self.over.wait(2)
        for sock in open_now:
            sock.close()


class Ask(Attack):
    """The same request again and again, answered and thrown away."""

    def __init__(self, name, world, method, path, body=b"", places=8, kind="application/json"):
        super().__init__(name, world, places)
        about = f"Content-Type: {kind}\r\nContent-Length: {len(body)}\r\n" if body else ""
        self.request = self.head(method, path, about) + body

    def run(self):
        workers = [threading.Thread(target=super(Ask, self).run, daemon=True) for _ in range(self.places)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()

    def attack(self):
        sock = self.connect()
        sock.settimeout(30)
        sock.sendall(self.request)
        first = sock.recv(16)
        self.count(status_of(first))
        while sock.recv(65536) and not self.over.is_set():
            break
        sock.close()


class Idle(Attack):
    """Connections that say nothing, or half a header."""

    def attack(self):
        held = []
        for i in range(self.places):
            if self.over.is_set():
                break
            sock = self.connect()
            if i % 4 == 0:
                sock.sendall(b"GET / HTTP/1.1\r\nHost: lo")
            held.append(sock)
        self.over.wait(8)
        for sock in held:
            sock.close()


class Runs(Attack):
    """Starts as many runs and replays as it is let."""

    def attack(self):
        for body in ({"duration_s": 600}, {"recording": self.world.recording}):
            answer = self.world.enemy_call("POST", "runs", body)
            self.count(answer.status)
        self.over.wait(0.2)


class Windows(Attack):
    """WebSockets that never read, on whatever run there is."""

    def attack(self):
        held = []
        for _ in range(self.places):
            if self.over.is_set():
                break
            token = self.world.enemy_call("POST", f"runs/{self.world.enemy_run()}/stream-token", {})
            self.count(token.status)
            code = token.body.get("code")
            if not code:
                break
            sock = self.connect(receive_bytes=4096)
            sock.sendall(
                self.head(
                    "GET",
                    f"/ws?code={code}",
                    "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n",
                )
            )
            held.append(sock)
        self.over.wait(5)
        for sock in held:
            sock.close()


def all_attacks(world):
    runs = f"/api/v1/runs/{world.recording}"
    zeros = gzip.compress(bytes(79 << 20))  # 78 kB
    guess = json.dumps({"login": "admin", "password": "not the password"}).encode()
    return [
        Unread(world, f"{runs}/frames", 40),
        Unread(world, f"{runs}/export.mat", 12),
        HalfUploads("uploads without an end", world, 30),
        Ask("figures", world, "GET", f"{runs}/plots/signals.png", places=12),
        Ask("HEAD of figures", world, "HEAD", f"{runs}/plots/estimates.png", places=12),
        Ask("reports", world, "GET", f"{runs}/report.pdf", places=8),
        Ask("packed zeros", world, "POST", "/api/v1/recordings", zeros, places=6, kind="application/gzip"),
        Ask("searches", world, "GET", f"/api/v1/runs?limit=200&q={'a' * 99}b", places=8),
        Ask("guesses", world, "POST", "/api/v1/auth/login", guess, places=12),
        Ask("lists", world, "GET", "/api/v1/runs?limit=200", places=16),
        Idle("idle connections", world, 1500),
        Runs("runs", world),
        Windows("windows", world, 100),
    ]


