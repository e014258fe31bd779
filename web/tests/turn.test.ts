import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { ApiError } from "../src/api/client";
import { Turn } from "../src/shell/turn.svelte";

const inLine = (place: number) =>
  new ApiError(503, {
    reason: "in_line",
    detail: "",
    parameters: { place: String(place), seconds: "9", again_s: "2" },
  });

describe("a turn at a simulator", () => {
  beforeEach(() => vi.useFakeTimers());
  afterEach(() => vi.useRealTimers());

  it("is awaited by asking again, and says the place", async () => {
    const turn = new Turn();
    const ask = vi
      .fn()
      .mockRejectedValueOnce(inLine(2))
      .mockRejectedValueOnce(inLine(1))
      .mockResolvedValueOnce("run");
    const run = turn.await(ask);
    await vi.advanceTimersByTimeAsync(0);
    expect([turn.place, turn.seconds]).toEqual([2, 9]);
    await vi.advanceTimersByTimeAsync(2000);
    expect(turn.place).toBe(1);
    await vi.advanceTimersByTimeAsync(2000);
    expect(await run).toBe("run");
    expect(turn.place).toBeNull();
  });

  it("ends when the line is left, or by any other refusal", async () => {
    const turn = new Turn();
    const ask = vi.fn().mockRejectedValue(inLine(1));
    const run = turn.await(ask);
    await vi.advanceTimersByTimeAsync(0);
    turn.leave();
    expect(await run).toBeNull();
    expect(ask).toHaveBeenCalledTimes(1);
    const other = new ApiError(429, { reason: "your_runs_full", detail: "" });
    await expect(turn.await(vi.fn().mockRejectedValue(other))).rejects.toBe(other);
    expect(turn.place).toBeNull();
  });
});
