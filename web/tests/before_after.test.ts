import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { spanAround, stretchesAround } from "../src/live/before_after";

interface Case {
  name: string;
  period_s: number;
  window: number;
  integral: number;
  at_s: number | null;
  changes: number[];
  end_s: number;
  before: [number, number];
  after: [number, number];
}

/** The server's report is tested with the same list. */
const cases: Case[] = JSON.parse(
  readFileSync(new URL("../../tests/server/api/before_after_cases.json", import.meta.url), "utf8"),
);

describe("what is averaged before and after a change", () => {
  it.each(cases)("$name", (each) => {
    const span = spanAround(each.at_s, each.changes, each.end_s);
    const found = stretchesAround(span, each, each.period_s);
    expect(found.before[0]).toBeCloseTo(each.before[0], 9);
    expect(found.before[1]).toBeCloseTo(each.before[1], 9);
    expect(found.after[0]).toBeCloseTo(each.after[0], 9);
    expect(found.after[1]).toBeCloseTo(each.after[1], 9);
  });
});
