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
    expect(slide.value(0, 10)).toBeNaN();
    expect(gapSpans(slide)).toEqual([[0.04, 0.2]]);
    slide.append(block(5, 15, identity));
    expect(slide.missing).toBe(0);
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
