import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { api, call, NoAnswer } from "../src/api/client";
import { Connection } from "../src/loading/connection.svelte";

describe("the search for a server that is away", () => {
  beforeEach(() => void vi.useFakeTimers());
  afterEach(() => void vi.useRealTimers());

  it("is one for all who wait, with longer and longer pauses, and says so while it lasts", async () => {
    const answers = [false, false, false, true];
    const asked: number[] = [];
    const connection = new Connection(async () => {
      asked.push(Date.now());
      return answers.shift() ?? true;
    });
    const begun = Date.now();
    const all = Promise.all([connection.again(), connection.again()]);
    expect(connection.away).toBe(false);
    await vi.advanceTimersByTimeAsync(400);
    expect(connection.away).toBe(true);
    await vi.advanceTimersByTimeAsync(5000);
    await all;
    expect(connection.away).toBe(false);
    expect(asked).toHaveLength(4);
    const pauses = asked.map((at, index) => at - (asked[index - 1] ?? begun));
    expect(pauses[3]).toBeGreaterThan(pauses[0] ?? Number.NaN);
  });
});

describe("a request without an answer", () => {
  let up = false;
  const sent: string[] = [];
  beforeEach(() => {
    vi.useFakeTimers();
    sent.length = 0;
    up = false;
    vi.stubGlobal("fetch", async (path: string, init: RequestInit = {}) => {
      sent.push(`${init.method ?? "GET"} ${path}`);
      if (!up) throw new TypeError("Failed to fetch");
      return Response.json({ id: "run-1" });
    });
  });
  afterEach(() => {
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  it("is repeated when the server answers again, if it reads", async () => {
    const run = api.run("run-1");
    await vi.advanceTimersByTimeAsync(3000);
    up = true;
    await vi.advanceTimersByTimeAsync(5000);
    expect((await run).id).toBe("run-1");
    expect(sent.filter((each) => each === "GET /api/v1/runs/run-1")).toHaveLength(2);
  });

  it("is given up when only its address does not answer", async () => {
    vi.stubGlobal("fetch", async (path: string) => {
      sent.push(path);
      if (path !== "/healthz") throw new TypeError("Failed to fetch");
      return new Response("ok");
    });
    const asked = api.run("run-1").catch((error: unknown) => error);
    await vi.advanceTimersByTimeAsync(20_000);
    expect(await asked).toBeInstanceOf(NoAnswer);
    expect(sent.filter((each) => each !== "/healthz")).toHaveLength(4);
  });

  it("is never repeated, if it changes something, and says so in words", async () => {
    const stopped = call("POST /runs/{id}/stop", { id: "run-1" }).catch((error: unknown) => error);
    const error = await stopped;
    up = true;
    await vi.advanceTimersByTimeAsync(5000);
    expect(error).toBeInstanceOf(NoAnswer);
    expect(String(error)).not.toContain("TypeError");
    expect(sent.filter((each) => each.startsWith("POST"))).toHaveLength(1);
  });
});
