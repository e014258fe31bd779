import { describe, expect, it } from "vitest";
import { gapSpans, moments } from "../src/live/statistics";
import { STATUS_NOT_EXCITED, STATUS_WEAK } from "../src/stream/frame";
import { Slide } from "../src/stream/slide";
import { block, random } from "./support/blocks";

const identity = (channel: number, index: number) => channel * 100_000 + index;

describe("Slide", () => {
  it("keeps the newest window contiguous while samples stream through it", () => {
    const slide = new Slide(100, 0.01);
    for (let first = 0; first < 1000; first += 5) {
      slide.append(block(first, 5, identity));
      const end = first + 5;
      expect(slide.end).toBe(end);
      expect(slide.missing).toBe(0);
      const oldest = Math.max(0, end - 100);
      expect(slide.first).toBe(oldest);
      const [from, to] = slide.range(0, 1e9);
      expect(to - from).toBe(end - oldest);
      for (const index of [oldest, Math.floor((oldest + end) / 2), end - 1]) {
        expect(slide.value(3, index)).toBe(300_000 + index);
        expect(slide.time[slide.slot(index)]).toBeCloseTo(index * 0.01, 9);
      }
    }
  });

  it("leaves lost samples NaN, counts them, and takes them when they come late", () => {
    const slide = new Slide(200, 0.01);
    slide.append(block(0, 5, identity));
    slide.append(block(20, 5, identity));
    expect(slide.missing).toBe(15);
    expect(slide.firstMissing).toBe(5);
    expect(slide.value(0, 10)).toBeNaN();
    expect(gapSpans(slide)).toEqual([[0.04, 0.2]]);
    slide.append(block(5, 15, identity));
    expect(slide.missing).toBe(0);
    expect(slide.firstMissing).toBe(25);
    expect(slide.value(0, 10)).toBe(10);
    expect(gapSpans(slide)).toEqual([]);
  });

  it("survives a gap longer than all it holds", () => {
    const slide = new Slide(50, 0.01);
    slide.append(block(0, 5, identity));
    slide.append(block(10_000, 5, identity));
    expect(slide.end).toBe(10_005);
    expect(slide.missing).toBe(9995);
    expect(slide.value(1, 10_004)).toBe(110_004);
    expect(slide.value(1, 9_990)).toBeNaN();
  });

  it("equals a plain map of the samples after any order of blocks within the window", () => {
    const next = random(3);
    for (let round = 0; round < 50; round++) {
      const slide = new Slide(64, 0.01);
      const truth = new Map<number, number>();
      let head = 0;
      for (let step = 0; step < 60; step++) {
        const late = next() < 0.3;
        const first = late
          ? Math.max(0, head - Math.floor(next() * 40))
          : head + Math.floor(next() * 8);
        const count = 1 + Math.floor(next() * 6);
        slide.append(block(first, count, identity));
        for (let index = first; index < first + count; index++) truth.set(index, index);
        head = Math.max(head, first + count);
        const wrong: number[] = [];
        for (let index = slide.first; index < slide.end; index++) {
          const expected = truth.get(index) ?? Number.NaN;
          if (!Object.is(slide.value(0, index), expected)) wrong.push(index);
        }
        expect(wrong).toEqual([]);
      }
    }
  });

  it("withholds an estimate that is not excited and keeps a weak one", () => {
    const slide = new Slide(50, 0.01);
    slide.append(block(0, 5, identity, STATUS_NOT_EXCITED));
    slide.append(block(5, 5, identity, STATUS_WEAK));
    expect(slide.value(1, 2)).toBe(100_002);
    expect(slide.value(5, 2)).toBeNaN();
    expect(slide.value(5, 7)).toBe(500_007);
  });
});

describe("the view of a slide", () => {
  const wave = (channel: number, index: number) =>
    index % 977 === 0 ? Number.NaN : Math.sin(index / 7) * channel + (index % 1013 === 5 ? 99 : 0);

  it("is the samples themselves where each has a pixel", () => {
    const slide = new Slide(4000, 0.001);
    slide.append(block(0, 4000, wave));
    const [time, values] = slide.view(1, 1.5, [3], 2);
    expect(time.length).toBe(503);
    expect(time[1]).toBeCloseTo(1, 9);
    expect(values?.[1]).toBeCloseTo(slide.value(3, 1000), 6);
  });

  it.each([8, 20, 100, 5000])(
    "has the lowest and the highest of all samples where %i share a pixel, and not many more",
    (perPixel) => {
      const count = 100_000;
      const slide = new Slide(60_000, 0.001); // what it holds has moved by then
      const next = random(perPixel);
      for (let at = 0; at < count; ) {
        const size = 1 + Math.floor(next() * 200);
        slide.append(block(at, Math.min(size, count - at), wave));
        at += size;
      }
      const [time, low = new Float32Array(0)] = slide.view(0, 1e9, [2], perPixel);
      expect(time.length).toBe(low.length);
      expect(time.length).toBeLessThan(
        (4 * (slide.end - slide.first)) / Math.min(perPixel, 1024) + 4,
      );
      const worst: string[] = [];
      for (let at = 0; at < time.length; at += 2) {
        const from = Math.round((time[at] as number) / 0.001);
        const bucket = 2 * Math.round(((time[at + 1] as number) - (time[at] as number)) / 0.001);
        expect(bucket).toBeLessThanOrEqual(perPixel);
        const all: number[] = [];
        for (let index = from; index < from + bucket; index++) {
          const value = slide.value(2, index);
          if (Number.isFinite(value)) all.push(value);
        }
        if (low[at] !== Math.min(...all) || low[at + 1] !== Math.max(...all))
          worst.push(`at ${from}`);
      }
      expect(worst).toEqual([]);
    },
  );

  it("takes late samples, and leaves a bucket of lost ones empty", () => {
    const slide = new Slide(4000, 0.001);
    slide.append(block(0, 500, () => 1));
    slide.append(block(700, 500, () => 1));
    const at = (index: number) => {
      const [time, values = new Float32Array(0)] = slide.view(0, 2, [0], 64);
      return values[time.findIndex((t) => t >= index * 0.001 - 1e-9)];
    };
    expect(at(576)).toBeNaN();
    slide.append(block(500, 200, () => 5));
    expect(at(576)).toBe(5);
  });

  it("is bounded: 600 s at 1 kHz hold what one sample of each needs, and half of that", () => {
    const slide = new Slide(600_000, 0.001);
    const [time, ...columns] = slide.view(0, 600, [0, 1, 2], 1000);
    slide.append(block(0, 5, () => 0));
    expect(columns.every((column) => column.length === time.length)).toBe(true);
    const held = slide.columns.length * (slide.columns[0]?.byteLength ?? 0);
    expect(held / 1e6).toBeLessThan(60);
  });
});

describe("moments", () => {
  it("are those of the samples in the span, NaN left out", () => {
    const slide = new Slide(100, 0.01);
    slide.append(block(0, 10, (_, index) => (index === 4 ? Number.NaN : index)));
    const found = moments(slide, 0, 0.02, 0.06);
    expect(found?.count).toBe(3);
    expect(found?.mean).toBeCloseTo(10 / 3, 12);
    expect(found?.deviation).toBeCloseTo(Math.sqrt(7 / 3), 12);
  });
});
