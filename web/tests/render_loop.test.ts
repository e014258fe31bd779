import { describe, expect, it, vi } from "vitest";
import { RenderLoop } from "../src/charts/render_loop";
import { grown, niceRange, spread } from "../src/charts/y_range";
import { columnExtremes } from "../src/live/overview";
import { Slide } from "../src/stream/slide";
import { block } from "./support/blocks";

function run(loop: RenderLoop, from: number, forMs: number, interval: number): number {
  let now = from;
  for (; now < from + forMs; now += interval) loop.frame(now);
  return now;
}

describe("RenderLoop", () => {
  it("draws less often when frames stay slow, says so, and recovers", () => {
    const said: number[] = [];
    const loop = new RenderLoop((rate) => said.push(rate));
    let now = run(loop, 0, 5000, 16);
    expect(said).toEqual([]);
    now = run(loop, now, 9000, 50);
    expect(said[0]).toBe(30);
    run(loop, now, 60_000, 16);
    expect(said.at(-1)).toBe(60);
  });
  it("does not take a hidden tab for a slow one", () => {
    const said = vi.fn();
    const loop = new RenderLoop(said);
    for (let minute = 0; minute < 20; minute++) run(loop, minute * 60_000, 200, 16);
    expect(said).not.toHaveBeenCalled();
  });
  it("draws each thing once a frame until it is taken away", () => {
    const draw = vi.fn();
    const loop = new RenderLoop();
    const remove = loop.add({ draw });
    run(loop, 0, 160, 16);
    expect(draw).toHaveBeenCalledTimes(10);
    remove();
    run(loop, 1000, 160, 16);
    expect(draw).toHaveBeenCalledTimes(10);
  });
});

describe("ranges", () => {
  it("end on round numbers and hold what they must", () => {
    for (const [low, high] of [
      [1.49, 2.41],
      [-0.98, -0.31],
      [0.018, 0.142],
      [5, 5],
    ] as const) {
      const [from, to] = niceRange(low, high);
      expect(from).toBeLessThan(low);
      expect(to).toBeGreaterThan(high);
    }
  });
  it("grow but never shrink", () => {
    expect(grown([0, 3], 1, 2)).toEqual([0, 3]);
    const [from, to] = grown([0, 3], -0.5, 2);
    expect(from).toBeLessThanOrEqual(-0.5);
    expect(to).toBeGreaterThanOrEqual(3);
  });
  it("do not follow single wild values", () => {
    const column = new Float32Array(1000).fill(1);
    column[10] = 1e9;
    column[11] = Number.NaN;
    expect(spread([column], 0, 1000)).toEqual([1, 1]);
  });
});

describe("overview", () => {
  it("never drops an extreme value", () => {
    const slide = new Slide(5000, 0.01);
    slide.append(block(0, 5000, (_, index) => (index === 3333 ? 50 : index === 1111 ? -50 : 0)));
    const envelope = columnExtremes(slide, 0, 50, 100);
    expect(Math.max(...envelope)).toBe(50);
    expect(Math.min(...envelope)).toBe(-50);
  });
});
