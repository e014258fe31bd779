import { beforeAll, describe, expect, it } from "vitest";
import type { Change, Episode, Finding, Run, Story } from "../src/contract/types";
import { i18n } from "../src/i18n/i18n.svelte";
import { overlayCsv } from "../src/pages/compared_runs";
import { foundWords, happenedWords } from "../src/pages/run_summary";
import { bench } from "./support/bench";
import { change, episode, finding, NOTHING } from "./support/stories";

beforeAll(() => i18n.loadAll());

const told = (changes: Change[], findings: Finding[] = []): Story => ({
  ...NOTHING,
  changes,
  episodes: findings.map((each) => episode(8, { finding: each as Episode["finding"] })),
});
function run(more: Partial<Run>): Run {
  const plan = {
    excitation: { kind: "prbs" },
    faults: [{ component: "R1", value: 100, at_s: 44 }],
  };
  return { state: "stopped", period_s: 0.01, verdict: "fault", plan, ...more } as Run;
}

describe("a run in the list", () => {
  it("is told by what happened, not by what was planned", () => {
    const story = told([change("R12", 2000, 9.5)]);
    expect(happenedWords(run({ story }), bench)).toBe("PRBS, R12 → 2 kΩ @ 9.5 s");
  });
  it("says why nothing happened", () => {
    const of = (more: Partial<Run>) => happenedWords(run({ story: NOTHING, ...more }), bench);
    expect(of({ samples: 380 })).toBe("PRBS, ended at 3.8 s, before its fault");
    const prbs = { excitation: { kind: "prbs" } };
    expect(of({ plan: prbs as Run["plan"] })).toBe("PRBS, no fault");
    const sealed = { ...prbs, sealed: true } as Run["plan"];
    expect(of({ plan: sealed })).toBe("PRBS, sealed");
    expect(foundWords(run({ plan: sealed, verdict: "calibrating" }), bench)).toBe(
      "Sealed until the exercise is released",
    );
  });
  it("is told by its plan while nothing has happened yet", () => {
    expect(happenedWords(run({ state: "running", story: NOTHING }), bench)).toBe(
      "PRBS, R1 → 100 Ω @ 44 s",
    );
  });
  it("shows its first and last changes, when there are many", () => {
    const value = (atS: number) => (atS === 20 ? 2 : 100 + atS);
    const story = told([10, 20, 30, 40].map((atS) => change("R1", value(atS), atS)));
    expect(happenedWords(run({ story }), bench)).toBe(
      "PRBS, R1 → 110 Ω @ 10 s, …, R1 → 130 Ω @ 30 s, R1 → 140 Ω @ 40 s",
    );
  });
  it("names the component and its value, all that look alike, and every fault", () => {
    const R1 = finding("R1", 8);
    const alike = finding("J", 20, { group: ["J", "R12"] });
    expect(foundWords(run({ story: told([], [R1, alike]) }), bench)).toBe(
      "Fault: R1 ↑ 56 Ω; Fault: R12 or J",
    );
  });
  it("tells the same of a bench that cannot be had, without its values", () => {
    const alike = finding("J", 20, { group: ["J", "R12"] });
    const back = run({ verdict: "nominal", story: told([change("R12", 2000, 9.5)], [alike]) });
    expect(happenedWords(back, undefined)).toBe("PRBS, R12 @ 9.5 s");
    expect(foundWords(back, undefined)).toBe("Fault: J or R12");
  });
  it("says that there is no verdict when the rig was never learnt", () => {
    expect(foundWords(run({ verdict: "calibrating", story: NOTHING }), bench)).toBe("No verdict");
    expect(foundWords(run({ verdict: "nominal", story: NOTHING }), bench)).toBe("No fault");
  });
});

describe("a comparison as CSV", () => {
  it("has what is visible, with a gap where a run has no sample", () => {
    const data = {
      x: Float64Array.from([-1, 0, 1, 2]),
      y: [Float32Array.from([1, 2, 3, 4]), Float32Array.from([Number.NaN, 5, 6, 7])],
    };
    expect(overlayCsv(data, ['a "b"', "c"], 0, 1)).toBe('t_s,"a ""b""","c"\n0,2,5\n1,3,6\n');
    expect(overlayCsv(data, ["a", "c"], -1, -1)).toBe('t_s,"a","c"\n-1,1,\n');
  });
});
