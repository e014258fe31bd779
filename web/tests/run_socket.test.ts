import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { encodeFrame } from "../src/stream/frame";
import { PlayoutClock } from "../src/stream/playout_clock";
import { type RunSocketEvents, runSocket } from "../src/stream/run_socket";
import { block } from "./support/blocks";

class Wire {
  static made: Wire[] = [];
  readyState = 1;
  binaryType = "";
  sent: string[] = [];
  onmessage: ((event: { data: unknown }) => void) | null = null;
  onclose: (() => void) | null = null;
  constructor(readonly url: string) {
    Wire.made.push(this);
  }
  send(text: string) {
    this.sent.push(text);
  }
  close() {
    this.readyState = 3;
  }
  say(message: unknown) {
    this.onmessage?.({ data: JSON.stringify(message) });
  }
  cut() {
    this.readyState = 3;
    this.onclose?.();
  }
}

let clockMs = 1000;
const hello = { type: "hello", state: "running", epoch: 1 };

function make(address = async () => "ws://host/ws?code=1") {
  const events: RunSocketEvents = {
    hello: vi.fn(),
    block: vi.fn(),
    message: vi.fn(),
    phase: vi.fn(),
    roundTrip: vi.fn(),
    refused: vi.fn(),
  };
  let end = 0;
  const socket = runSocket({
    address,
    nextIndex: () => end,
    isFatal: (error) => (error as Error).message === "404",
    events,
    open: (url) => new Wire(url) as unknown as WebSocket,
    now: () => clockMs,
    random: () => 1,
  });
  return { socket, events, setEnd: (index: number) => (end = index) };
}
const wire = (at: number) => Wire.made[at] as Wire;

describe("RunSocket", () => {
  beforeEach(() => {
    vi.useFakeTimers();
    Wire.made = [];
    clockMs = 1000;
  });
  afterEach(() => vi.useRealTimers());

  it("asks for what it does not have, again after every cut", async () => {
    const { socket, setEnd } = make();
    await socket.connect();
    wire(0).say(hello);
    expect(wire(0).sent).toContain('{"type":"resume","since":0}');
    setEnd(735);
    wire(0).cut();
    await vi.advanceTimersByTimeAsync(250);
    wire(1).say(hello);
    expect(wire(1).sent).toContain('{"type":"resume","since":735}');
    socket.close();
  });

  it("waits longer after each failure, 8 s at most, and starts again after success", async () => {
    let tries = 0;
    const { socket } = make(async () => {
      tries++;
      throw new Error("down");
    });
    await socket.connect();
    const waits = [250, 500, 1000, 2000, 4000, 8000, 8000];
    for (const [at, wait] of waits.entries()) {
      await vi.advanceTimersByTimeAsync(wait - 1);
      expect(tries).toBe(at + 1);
      await vi.advanceTimersByTimeAsync(1);
      expect(tries).toBe(at + 2);
    }
    socket.close();
  });

  it("takes a link on which nothing comes any more for dead, though the socket says nothing", async () => {
    const { socket, events, setEnd } = make();
    await socket.connect();
    wire(0).say(hello);
    for (let second = 0; second < 8; second += 2) {
      clockMs += 2000;
      await vi.advanceTimersByTimeAsync(2000);
    }
    expect(Wire.made.length).toBe(1);
    clockMs += 2000;
    await vi.advanceTimersByTimeAsync(2000);
    expect(events.phase).toHaveBeenLastCalledWith("waiting");
    expect(wire(0).readyState).toBe(3);
    setEnd(12);
    await vi.advanceTimersByTimeAsync(250);
    wire(1).say(hello);
    expect(wire(1).sent).toContain('{"type":"resume","since":12}');
    socket.close();
  });

  it("does not take a link for dead because the tab slept, but soon if it is", async () => {
    const { socket, events } = make();
    await socket.connect();
    wire(0).say(hello);
    clockMs += 60_000; // frozen: no timer ran
    await vi.advanceTimersByTimeAsync(2000);
    expect(events.phase).toHaveBeenLastCalledWith("open");
    wire(0).say({ type: "pong", t: clockMs, server_t: 1 });
    clockMs += 2000;
    await vi.advanceTimersByTimeAsync(2000);
    expect(events.phase).toHaveBeenLastCalledWith("open");
    clockMs += 60_000;
    await vi.advanceTimersByTimeAsync(2000);
    for (let second = 0; second < 4; second += 2) {
      clockMs += 2000;
      await vi.advanceTimersByTimeAsync(2000);
    }
    expect(events.phase).toHaveBeenLastCalledWith("waiting");
    socket.close();
  });

  it("tries at once when the network comes back, and only while it waits", async () => {
    const { socket } = make();
    await socket.connect();
    wire(0).say(hello);
    socket.wake();
    expect(Wire.made.length).toBe(1);
    wire(0).cut();
    socket.wake();
    await vi.advanceTimersByTimeAsync(0);
    expect(Wire.made.length).toBe(2);
    await vi.advanceTimersByTimeAsync(250);
    expect(Wire.made.length).toBe(2);
    socket.close();
  });

  it("gives up when the server says no for good", async () => {
    const { socket, events } = make(async () => {
      throw new Error("404");
    });
    await socket.connect();
    await vi.advanceTimersByTimeAsync(60_000);
    expect(events.refused).toHaveBeenCalledOnce();
  });

  it("hands on frames and messages, and is silent after the end", async () => {
    const { socket, events } = make();
    await socket.connect();
    wire(0).say(hello);
    wire(0).onmessage?.({ data: encodeFrame(block(5, 5, () => 1)) });
    expect(events.block).toHaveBeenCalledWith(expect.objectContaining({ firstIndex: 5, count: 5 }));
    wire(0).say({ type: "end", state: "finished" });
    wire(0).cut();
    await vi.advanceTimersByTimeAsync(60_000);
    expect(Wire.made.length).toBe(1);
  });

  it("measures the round trip by its own clock", async () => {
    const { socket, events } = make();
    await socket.connect();
    wire(0).say(hello);
    wire(0).say({ type: "pong", t: 988, server_t: 1 });
    expect(events.roundTrip).toHaveBeenCalledWith(0.012);
    socket.close();
  });
});

describe("PlayoutClock", () => {
  it("follows the quickest frame, 100 ms behind, whatever the jitter", () => {
    const clock = new PlayoutClock();
    const jitter = [0.03, 0, 0.2, 0.01, 0.15, 0.02];
    for (const [at, late] of jitter.entries()) clock.observe(at * 0.05, 50 + at * 0.05 + late);
    expect(clock.time(51)).toBeCloseTo(0.9, 2);
  });
  it("stands still when the run is over", () => {
    const clock = new PlayoutClock();
    clock.observe(1, 10);
    clock.freeze(20);
    expect(clock.time(999)).toBe(20);
  });
});
