import { describe, expect, it } from "vitest";
import { takenAt } from "../src/live/bench/camera_feed.svelte";
import { SLOWER, turned } from "../src/live/bench/turning";

describe("the drawn motor", () => {
  it("turns so many times slower than the measured n, in its direction", () => {
    expect(turned(0, 60 * SLOWER, 0.25)).toBeCloseTo(90);
    expect(turned(350, 60 * SLOWER, 0.25)).toBeCloseTo(80);
    expect(turned(0, -60 * SLOWER, 0.25)).toBeCloseTo(-90);
  });
  it("stands where n is not known", () => {
    expect(turned(12, Number.NaN, 1)).toBe(12);
  });
});

describe("a picture", () => {
  it("is as old as the server says, from the moment its answer came", () => {
    const answer = new Response(null, { headers: { "X-Picture-Age-Ms": "120" } });
    expect(takenAt(answer, 5000)).toBe(4880);
    expect(takenAt(new Response(null), 5000)).toBe(5000);
  });
});
