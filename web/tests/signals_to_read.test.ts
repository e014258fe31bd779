import { describe, expect, it } from "vitest";
import { groupsOf, placeLabel } from "../src/charts/decoration";
import { heldView, wheelFactor } from "../src/charts/gestures";
import { LOOK } from "../src/charts/markers";
import { Viewport } from "../src/charts/viewport.svelte";
import { Cursors } from "../src/live/cursors.svelte";
import { Lens } from "../src/live/lens.svelte";
import { slopeUnit, spanStatistics } from "../src/live/span_statistics";
import { Slide } from "../src/stream/slide";
import { block, random } from "./support/blocks";

const PERIOD = 0.01;
function slideOf(count: number, value: (index: number) => number): Slide {
  const slide = new Slide(Math.max(count, 10), PERIOD);
  slide.append(block(0, count, (_, index) => value(index)));
  return slide;
}

describe("zoom", () => {
  it("keeps the time under the pointer where it is", () => {
    const view = new Viewport(PERIOD);
    view.show(4, 14);
    view.zoom(0.5, 20, 6);
    expect(view.range(20)).toEqual([5, 10]); // 6 s stays at a fifth of the width
    view.zoom(2, 20, 6);
    expect(view.range(20)).toEqual([4, 14]);
  });
  it("ends at twenty samples and at 600 s", () => {
    const view = new Viewport(PERIOD);
    view.show(4, 14);
    for (let turn = 0; turn < 50; turn++) view.zoom(0.5, 20, 6);
    expect(view.span).toBeCloseTo(20 * PERIOD);
    for (let turn = 0; turn < 50; turn++) view.zoom(2, 20, 6);
    expect(view.span).toBe(600);
  });
  it("by wheel is symmetric and bounded for one turn", () => {
    expect(wheelFactor(12) * wheelFactor(-12)).toBeCloseTo(1);
    expect(wheelFactor(-10)).toBeLessThan(1);
    expect(wheelFactor(5000)).toBe(wheelFactor(40));
  });
});

describe("fingers", () => {
  it("one moves the view and keeps its span", () => {
    expect(heldView([{ place: 0.25, timeS: 10 }], 4)).toEqual([9, 13]);
  });
  it("two hold their times: apart they look closer", () => {
    const view = heldView(
      [
        { place: 0.1, timeS: 10 },
        { place: 0.9, timeS: 12 },
      ],
      20,
    );
    expect(view[0]).toBeCloseTo(9.75);
    expect(view[1]).toBeCloseTo(12.25);
  });
  it("two in one place, or crossed, do not change the span", () => {
    const span = (places: [number, number]) => {
      const [from, to] = heldView(
        [
          { place: places[0], timeS: 10 },
          { place: places[1], timeS: 12 },
        ],
        20,
      );
      return to - from;
    };
    expect(span([0.5, 0.51])).toBeCloseTo(20);
    expect(span([0.9, 0.1])).toBeCloseTo(20);
  });
});

describe("statistics of a span", () => {
  it("of a ramp: its slope per second, and both ends counted", () => {
    const slide = slideOf(1001, (index) => 2 + 0.03 * index);
    const found = spanStatistics(slide, 1, 1, 2);
    expect(found?.count).toBe(101);
    expect(found?.slope).toBeCloseTo(3, 4);
    expect(found?.centreS).toBeCloseTo(1.5);
    expect(found?.mean).toBeCloseTo(6.5, 4);
    expect(found?.min).toBeCloseTo(5, 4);
    expect(found?.max).toBeCloseTo(8, 4);
    // of n equidistant values: step * sqrt(n (n + 1) / 12)
    expect(found?.deviation).toBeCloseTo(0.03 * Math.sqrt((101 * 102) / 12), 4);
  });
  it("agrees with the normal equations on noise with missing samples", () => {
    const next = random(7);
    const values = Array.from({ length: 300 }, () => (next() < 0.2 ? Number.NaN : next() * 10));
    const slide = slideOf(300, (index) => values[index] as number);
    const found = spanStatistics(slide, 3, 0.5, 2.5);
    const used = values
      .map((y, index) => ({ t: index * PERIOD, y: Math.fround(y) }))
      .slice(50, 251)
      .filter(({ y }) => Number.isFinite(y));
    const sum = (of: (p: { t: number; y: number }) => number) =>
      used.reduce((total, p) => total + of(p), 0);
    const n = used.length;
    const slope =
      (n * sum((p) => p.t * p.y) - sum((p) => p.t) * sum((p) => p.y)) /
      (n * sum((p) => p.t ** 2) - sum((p) => p.t) ** 2);
    expect(found?.count).toBe(n);
    expect(found?.slope).toBeCloseTo(slope, 8);
    expect(found?.mean).toBeCloseTo(sum((p) => p.y) / n, 8);
  });
  it("keeps its digits on a large offset", () => {
    const slide = slideOf(1000, (index) => 4096 + (index % 2));
    expect(spanStatistics(slide, 0, 0, 9.99)?.deviation).toBeCloseTo(0.5, 3);
  });
  it("has no slope of one sample, and nothing to say of none", () => {
    const slide = slideOf(100, (index) => (index < 50 ? 1 : Number.NaN));
    expect(spanStatistics(slide, 0, 0.1, 0.1)).toMatchObject({ count: 1, deviation: 0, mean: 1 });
    expect(spanStatistics(slide, 0, 0.1, 0.1)?.slope).toBeNaN();
    expect(spanStatistics(slide, 0, 0.6, 0.9)).toBeNull();
    expect(spanStatistics(slide, 0, 5, 6)).toBeNull();
  });
  it("has a slope in the unit of the signal per second", () => {
    expect(["V", "rpm", "s", "V/V", "A/V", "A·s/V"].map(slopeUnit)).toEqual([
      "V/s",
      "rpm/s",
      "s/s",
      "1/s",
      "A/(V·s)",
      "A/V",
    ]);
  });
});

describe("cursors", () => {
  const slide = slideOf(500, () => 0);
  it("stand on samples, inside the record", () => {
    const cursors = new Cursors(slide);
    cursors.set("A", 1.2345);
    expect(cursors.a).toBeCloseTo(1.23);
    cursors.set("A", 99);
    expect(cursors.a).toBeCloseTo(4.99);
    cursors.set("A", -3);
    expect(cursors.a).toBe(0);
  });
  it("are placed by clicks: A, then B, then the nearer one", () => {
    const cursors = new Cursors(slide);
    cursors.pick(1);
    cursors.pick(3);
    expect(cursors.span).toEqual([1, 3]);
    cursors.pick(2.5);
    expect(cursors.span).toEqual([1, 2.5]);
    cursors.pick(0.5);
    expect(cursors.span).toEqual([0.5, 2.5]);
  });
  it("move by what is asked, but by a sample at least", () => {
    const cursors = new Cursors(slide);
    expect(cursors.move(1)).toBeNull();
    cursors.set("B", 2);
    expect(cursors.move(0.5)?.[1]).toBeCloseTo(2.5);
    expect(cursors.move(-0.0001)?.[1]).toBeCloseTo(2.49);
  });
  it("are gripped by who is near, the nearer one", () => {
    const cursors = new Cursors(slide);
    expect(cursors.grip(1, 0.1)).toBeNull();
    cursors.select(1, 1.1);
    expect(cursors.grip(1.08, 0.1)).toBe("B");
    expect(cursors.grip(0.8, 0.1)).toBeNull();
  });
  it("go when measuring ends", () => {
    const cursors = new Cursors(slide);
    cursors.select(1, 2);
    cursors.toggle();
    expect([cursors.on, cursors.a, cursors.b, cursors.span]).toEqual([false, null, null, null]);
  });
});

describe("the lens", () => {
  const slide = slideOf(2000, () => 0);
  const view = new Viewport(PERIOD);
  const lens = new Lens(view, slide);
  it("shows the newest second, else the one around the pointer", () => {
    expect(lens.range(20, null)).toEqual([19, 20]);
    expect(lens.range(20, 10)).toEqual([9.5, 10.5]);
    expect(lens.range(20, 19.9)).toEqual([19, 20]);
    expect(lens.range(20, 0.1)).toEqual([0, 1]);
  });
  it("shows nothing that the charts do not show", () => {
    view.show(0, 5);
    expect(lens.range(20, 10)).toEqual([4, 5]);
  });
});

describe("the label of a marker", () => {
  const room = { from: 0, to: 100 };
  const at = (x: number) => ({ from: x - 3, to: x + 3 });
  it("stands right of its symbol, a fault's left of it", () => {
    expect(placeLabel(at(50), 2, 20, room, [], false)).toEqual({ from: 55, to: 75 });
    expect(placeLabel(at(50), 2, 20, room, [], true)).toEqual({ from: 25, to: 45 });
  });
  it("goes to the other side, or is left out, when something is in the way", () => {
    expect(placeLabel(at(90), 2, 20, room, [], false)).toEqual({ from: 65, to: 85 });
    const right = { from: 60, to: 65 };
    expect(placeLabel(at(50), 2, 20, room, [right], false)).toEqual({ from: 25, to: 45 });
    const both = [right, { from: 30, to: 35 }];
    expect(placeLabel(at(50), 2, 20, room, both, false)).toBeNull();
  });
  it("symbols too close to each other stand in a row", () => {
    const marker = (timeS: number) => ({ kind: "detected" as const, timeS, label: "" });
    const groups = groupsOf(
      [10, 12, 13, 40].map((x) => ({ marker: marker(x), x })),
      3,
    );
    expect(groups.map(({ members, from, to }) => [members.length, from, to])).toEqual([
      [3, 7, 25],
      [1, 37, 43],
    ]);
  });
});

describe("colours of markers", () => {
  it("have red for what is wrong with the rig alone", () => {
    const colors = { fault: "red", detect: "blue", text: "black" };
    const of = (kind: keyof typeof LOOK) => colors[LOOK[kind].color];
    expect([of("fault"), of("trip")]).toEqual(["red", "red"]);
    expect([of("cursorA"), of("cursorB"), of("stopped")]).toEqual(["black", "black", "black"]);
    expect([of("detected"), of("isolated")]).toEqual(["blue", "blue"]);
  });
});
