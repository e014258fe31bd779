// A stand-in for the server, for work on the page without one: npm run fixture, then open the address
// it prints. One kind of run (PRBS, R1 fault) with invented noise; it serves dist/ and the parts of
// the contract that the live page uses. The browser tests use the real server, not this.
import { createHash, randomUUID } from "node:crypto";
import { existsSync, readFileSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join } from "node:path";

const port = Number(process.env.PORT ?? 8090);
const dist = new URL("../../dist", import.meta.url).pathname;
const T = 0.01;
const RELAYS = {
  R1: [1, 10, 56, 100],
  R9: [10e3, 33e3, 56e3, 100e3],
  R12: [10e3, 5600, 3300, 2000],
  C8: [47e-12, 1e-6, 10e-6, 47e-6],
};
const NOMINAL = { R1: 1, R9: 10e3, R12: 10e3, C8: 47e-12, Ra: 7.41, J: 1.43e-6, B: 1.8e-6 };
const runs = new Map();
const codes = new Map();

function theta(p) {
  const k = (p.R12 + 2e3) / ((p.R9 * 10e3) / (p.R9 + 10e3));
  const kk = 25.5e-3 ** 2;
  const d = p.B * (p.Ra + p.R1) + kk;
  const n = p.B * p.Ra + kk;
  const b0 = (k * n) / d;
  const b1 = (k * (p.J * p.Ra + p.C8 * 1e3 * n)) / d;
  const a1 = (p.J * (p.Ra + p.R1) + p.C8 * (1e3 + p.R12 + 2e3) * d) / d;
  const e = Math.exp(-T / a1);
  const b0d = b0 - (b0 - b1 / a1) * Math.exp(-0.0095 / a1);
  return { d: [b0d, b0 * (1 - e) - b0d, -e], c: [b0, b1, a1] };
}

class Run {
  constructor(request) {
    this.id = randomUUID().slice(0, 8);
    this.plan = {
      duration_s: 20,
      period_s: T,
      faults: [],
      excitation: { kind: "prbs" },
      ...request,
    };
    this.state = "running";
    this.created = new Date().toISOString();
    this.p = { ...NOMINAL };
    this.events = [];
    this.rows = [];
    this.viewers = new Set();
    this.u = 2;
    this.um = 4.8;
    this.history = [];
    this.verdict = { verdict: "calibrating", candidates: [], group: [], path: [] };
    this.start = Date.now();
    this.event({ kind: "started", index: 0 });
    this.timer = setInterval(() => this.tick(), 50);
  }
  event(event) {
    this.events.push({ t_s: event.index * T, ...event });
    this.send({ type: "event", ...this.events.at(-1) });
  }
  send(message) {
    for (const viewer of this.viewers) viewer.text(JSON.stringify(message));
  }
  set(component, value, index) {
    this.event({ kind: "fault_commanded", index, component, value });
    setTimeout(() => {
      this.p[component] = value;
      this.changed = this.rows.length;
      this.event({ kind: "relay_confirmed", index: this.rows.length, component, value });
    }, 120);
  }
  tick() {
    const due = Math.min(this.plan.duration_s / T, Math.floor((Date.now() - this.start) / 10));
    const from = this.rows.length;
    for (let k = from; k < due; k++) this.sample(k);
    for (let at = from; at + 5 <= due; at += 5) {
      const frame = this.frame(at, 5);
      for (const viewer of this.viewers) viewer.binary(frame);
    }
    this.rows.length = Math.max(from, Math.floor(due / 5) * 5);
    if (this.rows.length >= this.plan.duration_s / T) this.end("finished");
  }
  sample(k) {
    for (const fault of this.plan.faults) {
      if (k === Math.round(fault.at_s / T)) {
        this.p[fault.component] = fault.value;
        this.changed = k;
        this.fault = fault;
        this.event({ kind: "fault_commanded", index: k, ...fault });
        this.event({
          kind: "relay_confirmed",
          index: k,
          component: fault.component,
          value: fault.value,
        });
      }
    }
    if (this.fault && k === this.changed + 4) this.event({ kind: "detected", index: k });
    if (this.fault && k === this.changed + 100) {
      this.event({ kind: "isolated", index: k, component: this.fault.component });
      this.verdict = {
        verdict: "fault",
        detected_at_s: (this.changed + 4) * T,
        onset_s: this.changed * T,
        detector: "glr_25",
        group: [this.fault.component],
        settled: true,
        candidates: [
          {
            component: this.fault.component,
            value: this.fault.value * 0.994,
            sigma: this.fault.value * 0.004,
            unit: "ohm",
            bound: null,
            score: 1.02,
          },
          {
            component: "B",
            value: 5.1e-5,
            sigma: 2e-6,
            unit: "Nm/(rad/s)",
            bound: null,
            score: 3.3,
          },
        ],
        path: [
          {
            question: "b0 outside its band?",
            answer: true,
            value: 1.497,
            threshold: 2.351,
            leads_to: "a1",
          },
          {
            question: "a1 outside its band?",
            answer: true,
            value: 0.142,
            threshold: 0.0191,
            leads_to: "b1",
          },
          { question: "b1 fell?", answer: true, value: 0.0341, threshold: 0.0379, leads_to: "R1" },
        ],
        fit_percent: { swa: 96.1, sia: 97.2 },
      };
      this.send({ type: "verdict", ...this.verdict });
    }
    const { d, c } = theta(this.p);
    const noise = (s) => s * (Math.random() + Math.random() + Math.random() - 1.5);
    const u = Math.random() < 0.5 ? 2 : 3;
    const before = this.um;
    this.um = d[0] * u + d[1] * this.u - d[2] * this.um;
    this.u = u;
    const ia = (this.um - before) * 0.01 + 0.02 + noise(0.002);
    const row = [u, this.um + noise(0.02), this.um + ia * this.p.R1, ia, this.um * 98];
    for (const [w, family] of [
      [50, d],
      [100, d],
      [200, d],
      [25, c],
      [120, c],
      [520, c],
    ]) {
      const share = this.changed === undefined ? 1 : Math.min(1, (k - this.changed) / w);
      const old = family === d ? theta(NOMINAL).d : theta(NOMINAL).c;
      for (let i = 0; i < 3; i++) {
        const value = old[i] + (family[i] - old[i]) * share;
        row.push(k < w ? Number.NaN : value * (1 + noise(0.2 / w)));
      }
    }
    this.rows.push(row);
  }
  frame(first, count) {
    const buffer = Buffer.alloc(16 + count * 23 * 4 + count * 8);
    buffer.writeUInt8(1, 0);
    buffer.writeUInt8(1, 1);
    buffer.writeUInt16LE(count, 2);
    buffer.writeUInt32LE(first, 4);
    buffer.writeDoubleLE((Date.now() - this.start) / 1000, 8);
    for (let r = 0; r < count; r++) {
      for (const [i, v] of this.rows[first + r].entries()) {
        buffer.writeFloatLE(v, 16 + (r * 23 + i) * 4);
      }
    }
    return buffer;
  }
  end(state) {
    if (this.state !== "running") return;
    clearInterval(this.timer);
    this.state = state;
    this.event({ kind: state, index: this.rows.length });
    this.send({ type: "end", state });
  }
  json() {
    return {
      id: this.id,
      rig: "sim-1",
      state: this.state,
      plan: this.plan,
      epoch: 1,
      created_at: this.created,
      samples: this.rows.length,
      events: this.events,
      verdict: this.verdict.verdict,
    };
  }
  hello() {
    const { d, c } = theta(NOMINAL);
    return {
      type: "hello",
      run: this.id,
      state: this.state,
      epoch: 1,
      first_index: 0,
      next_index: this.rows.length,
      rate_hz: 100,
      nominal: { swa: d, sia: c },
      plan: this.plan,
      positions: Object.fromEntries(
        Object.entries(this.p).map(([k, value]) => [k, { value, state: "confirmed" }]),
      ),
      can_command: true,
      events: this.events,
      verdict: this.verdict,
    };
  }
}

/** The server side of one WebSocket (RFC 6455), as much as a page needs. */
class Viewer {
  constructor(socket, run) {
    this.socket = socket;
    this.buffer = Buffer.alloc(0);
    this.text(JSON.stringify(run.hello()));
    run.viewers.add(this);
    socket.on("close", () => run.viewers.delete(this));
    socket.on("error", () => run.viewers.delete(this));
    socket.on("data", (data) => {
      this.buffer = Buffer.concat([this.buffer, data]);
      for (let text = this.next(); text !== null; text = this.next()) this.command(run, text);
    });
  }
  next() {
    const b = this.buffer;
    if (b.length < 6) return null;
    let length = b[1] & 0x7f;
    let at = 2;
    if (length === 126) {
      length = b.readUInt16BE(2);
      at = 4;
    }
    if (b.length < at + 4 + length) return null;
    const mask = b.subarray(at, at + 4);
    const text = Buffer.from(b.subarray(at + 4, at + 4 + length).map((c, i) => c ^ mask[i % 4]));
    this.buffer = b.subarray(at + 4 + length);
    if ((b[0] & 15) === 8) this.socket.end();
    return (b[0] & 15) === 1 ? text.toString() : "{}";
  }
  command(run, text) {
    const message = JSON.parse(text);
    if (message.type === "ping")
      this.text(JSON.stringify({ type: "pong", t: message.t, server_t: 0 }));
    if (message.type === "resume") {
      for (let at = message.since - (message.since % 5); at + 5 <= run.rows.length; at += 5)
        this.binary(run.frame(at, 5));
    }
    if (message.type === "command") {
      if (message.action === "set") run.set(message.component, message.value, run.rows.length);
      if (message.action === "nominal") {
        for (const [c, v] of Object.entries(NOMINAL))
          if (run.p[c] !== v) run.set(c, v, run.rows.length);
      }
      this.text(JSON.stringify({ type: "ack", id: message.id, ok: true }));
    }
  }
  text(payload) {
    this.write(1, Buffer.from(payload));
  }
  binary(payload) {
    this.write(2, payload);
  }
  write(opcode, payload) {
    const head =
      payload.length < 126 ? Buffer.from([0x80 | opcode, payload.length]) : Buffer.alloc(4);
    if (payload.length >= 126) {
      head[0] = 0x80 | opcode;
      head[1] = 126;
      head.writeUInt16BE(payload.length, 2);
    }
    this.socket.write(Buffer.concat([head, payload]));
  }
}

const TYPES = {
  ".js": "text/javascript",
  ".css": "text/css",
  ".svg": "image/svg+xml",
  ".html": "text/html",
};

const server = createServer((request, response) => {
  const url = new URL(request.url, "http://x");
  const json = (status, body) => {
    response.writeHead(status, { "Content-Type": "application/json" });
    response.end(JSON.stringify(body));
  };
  const path = url.pathname.replace("/api/v1", "");
  const run = runs.get(/^\/runs\/([^/]+)/.exec(path)?.[1]);
  if (!url.pathname.startsWith("/api/")) {
    if (url.pathname === "/readyz") return json(200, {});
    let file = join(dist, url.pathname);
    if (!extname(file) || !existsSync(file)) file = join(dist, "index.html");
    response.writeHead(200, {
      "Content-Type": TYPES[extname(file)] ?? "application/octet-stream",
      "Content-Security-Policy": "default-src 'self'",
    });
    return response.end(readFileSync(file));
  }
  if (path === "/auth/me") return json(200, { role: "guest", name: "guest" });
  if (path === "/recordings") return json(200, { items: [] });
  if (path === "/rigs") {
    const capabilities = {
      ua: true,
      ia: true,
      n: true,
      any_value: true,
      motor_faults: true,
      uc_v_min: 0,
      uc_v_max: 5,
    };
    const rig = {
      class: "bench-sim",
      kind: "simulated",
      profile: "bench",
      state: "idle",
      epoch: 1,
      capabilities,
      nominal: NOMINAL,
      relay_values: RELAYS,
    };
    return json(200, { items: [1, 2].map((n) => ({ id: `sim-${n}`, ...rig })) });
  }
  if (path === "/runs" && request.method === "POST") {
    let body = "";
    request.on("data", (data) => (body += data));
    request.on("end", () => {
      const made = new Run(body ? JSON.parse(body) : {});
      runs.set(made.id, made);
      json(201, made.json());
    });
    return;
  }
  if (path === "/runs")
    return json(200, {
      items: [...runs.values()].reverse().map((r) => r.json()),
      next_cursor: null,
    });
  if (!run) return json(404, { type: "about:blank", title: "Not found", status: 404 });
  if (path.endsWith("/stop")) {
    run.end("stopped");
    return json(202, {});
  }
  if (path.endsWith("/stream-token")) {
    const code = randomUUID();
    codes.set(code, run);
    return json(201, { code, expires_in_s: 30 });
  }
  if (path.endsWith("/diagnosis")) return json(200, run.verdict);
  if (path.endsWith("/frames")) {
    for (let at = 0; at + 5 <= run.rows.length; at += 5) {
      const frame = run.frame(at, 5);
      const length = Buffer.alloc(4);
      length.writeUInt32LE(frame.length);
      response.write(Buffer.concat([length, frame]));
    }
    return response.end();
  }
  return json(200, run.json());
});

server.on("upgrade", (request, socket) => {
  const code = new URL(request.url, "http://x").searchParams.get("code");
  const run = codes.get(code);
  codes.delete(code);
  if (!run) return socket.destroy();
  const key = request.headers["sec-websocket-key"];
  const accept = createHash("sha1")
    .update(`${key}258EAFA5-E914-47DA-95CA-C5AB0DC85B11`)
    .digest("base64");
  socket.write(
    `HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: ${accept}\r\n\r\n`,
  );
  new Viewer(socket, run);
});
server.listen(port, "127.0.0.1", () => console.log(`http://127.0.0.1:${port}`));
