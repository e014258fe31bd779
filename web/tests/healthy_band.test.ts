import { describe, expect, it } from "vitest";
import type { RunEvent } from "../src/contract/types";
import { healthyBand, learntStretch } from "../src/live/healthy_band";
import { Slide } from "../src/stream/slide";
import { block } from "./support/blocks";

const HEALTHY = { from_s: 1, to_s: 5 };
const timeOf = (event: RunEvent) => event.index * 0.01;
const event = (kind: string, index: number, value?: number) => ({ kind, index, value }) as RunEvent;
const CHANNEL = 9;

/** 1 ± 0.01 until 8 s, 3 from then on. */
function recorded(seconds: number): Slide {
  const slide = new Slide(2000, 0.01);
  const value = (_: number, index: number) => (index < 800 ? 1 + (index % 2 ? 0.01 : -0.01) : 3);
  for (let first = 0; first < seconds * 100; first += 5) slide.append(block(first, 5, value));
  return slide;
}

describe("the band of the healthy rig", () => {
  it("is of what was learnt, however much of the fault has been seen", () => {
    const stretch = learntStretch(HEALTHY, [], timeOf, null);
    const before = healthyBand(recorded(8), CHANNEL, stretch, 1);
    const [low, high] = before as [number, number];
    expect(low).toBeGreaterThan(0.96);
    expect(high).toBeLessThan(1.04);
    for (const seconds of [9, 12, 20]) {
      expect(healthyBand(recorded(seconds), CHANNEL, stretch, 1)).toEqual(before);
    }
  });
  it("is the same for who may not know of the fault", () => {
    const told = ["fault_commanded", "relay_confirmed", "detected", "isolated"].map((kind) =>
      event(kind, 800, 56),
    );
    expect(learntStretch(HEALTHY, told, timeOf, 8)).toEqual(
      learntStretch(HEALTHY, [], timeOf, null),
    );
  });
  it("follows what was learnt anew, and waits until an estimator's window is full", () => {
    const again = learntStretch(HEALTHY, [event("learning", 1000, 15)], timeOf, 8);
    expect(again).toEqual([10, 15]);
    expect(healthyBand(recorded(15), CHANNEL, again, 1)).toEqual([3, 3]);
    expect(healthyBand(recorded(8), CHANNEL, [1, 5], 4)).toBeNull();
  });
  it("ends before a fault of a run that had nothing to learn", () => {
    expect(learntStretch(HEALTHY, [], timeOf, 3)).toEqual([1, 3]);
  });
});
