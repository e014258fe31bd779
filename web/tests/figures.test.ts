import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { align } from "../src/figures/figure";
import { type ComparedRun, overlay } from "../src/pages/compared_runs";
import { entriesOf, type OpenApi } from "../src/pages/openapi";
import { Slide } from "../src/stream/slide";
import { block } from "./support/blocks";

describe("figure series", () => {
  it("come onto one axis, NaN where a series has no point", () => {
    const { x, y } = align([
      { x: [0, 1, 2], y: [10, 11, null] },
      { x: [1, 3], y: [21, 23] },
    ]);
    expect([...x]).toEqual([0, 1, 2, 3]);
    expect([...(y[0] as Float32Array)]).toEqual([10, 11, Number.NaN, Number.NaN]);
    expect([...(y[1] as Float32Array)]).toEqual([Number.NaN, 21, Number.NaN, 23]);
  });
});

describe("overlaid runs", () => {
  const compared = (samples: number, onsetS: number): ComparedRun => {
    const slide = new Slide(samples, 0.01);
    slide.append(block(0, samples, (_, index) => (index * 0.01 < onsetS - 1e-9 ? 0 : 1)));
    return { slide, onsetS, durationS: samples * 0.01 } as ComparedRun;
  };
  it("meet at their faults when aligned", () => {
    const { x, y } = overlay([compared(300, 1), compared(500, 2)], 0, true);
    const zero = x.findIndex((at) => Math.abs(at) < 1e-9);
    for (const column of y) {
      expect(column[zero - 1]).toBe(0);
      expect(column[zero]).toBe(1);
    }
    expect(x[0]).toBeCloseTo(-2, 9);
    expect(x.length).toBe(500);
  });
  it("start together otherwise", () => {
    const { x, y } = overlay([compared(300, 1), compared(500, 2)], 0, false);
    expect(x[0]).toBe(0);
    expect(y[0]?.indexOf(1)).toBe(100);
    expect(y[1]?.indexOf(1)).toBe(200);
  });
});

describe("reference of the REST interface", () => {
  const description = JSON.parse(
    readFileSync(new URL("../../server/api/openapi.json", import.meta.url), "utf8"),
  ) as OpenApi;
  it("lists every operation of the server's description once, with a summary", () => {
    const entries = entriesOf(description);
    expect(entries.length).toBeGreaterThan(10);
    expect(new Set(entries.map((entry) => entry.method + entry.path)).size).toBe(entries.length);
    expect(entries.filter((entry) => !entry.operation.summary)).toEqual([]);
  });
});
