import { beforeAll, describe, expect, it } from "vitest";
import type { Finding, Run } from "../src/api/types";
import { i18n } from "../src/i18n/i18n.svelte";
import { overlayCsv } from "../src/pages/compared_runs";
import { foundWords, happenedWords } from "../src/pages/run_summary";
import { bench } from "./support/bench";

beforeAll(() => i18n.loadAll());

const found = (component: string, group: string[], value: number, atS: number) => ({
  verdict: "fault" as const,
  detected_at_s: atS,
  onset_s: atS,
  ended_at_s: null,
  group,
  candidates: [{ component, value, sigma: 1, unit: "ohm", bound: null, score: 1, margin: 0 }],
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
    const changes = [{ component: "R12", value: 2000, at_s: 9.5 }];
    expect(happenedWords(run({ changes }), bench)).toBe("PRBS, R12 → 2 kΩ @ 9.5 s");
  });
  it("says why nothing happened", () => {
    const of = (more: Partial<Run>) => happenedWords(run({ changes: [], ...more }), bench);
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
    expect(happenedWords(run({ state: "running", changes: [] }), bench)).toBe(
      "PRBS, R1 → 100 Ω @ 44 s",
    );
  });
  it("shows its first and last changes, when there are many", () => {
    const changes = [10, 20, 30, 40].map((at_s) => ({
      component: "R1",
      value: at_s === 20 ? 2 : 100 + at_s,
      at_s,
    }));
    expect(happenedWords(run({ changes }), bench)).toBe(
      "PRBS, R1 → 110 Ω @ 10 s, …, R1 → 130 Ω @ 30 s, R1 → 140 Ω @ 40 s",
    );
  });
  it("names the component and its value, all that look alike, and every fault", () => {
    const findings: Run["findings"] = [
      found("R1", ["R1"], 99.8, 8),
      found("J", ["J", "R12"], 3e-5, 20),
    ];
    expect(foundWords(run({ findings }), bench)).toBe("Fault: R1 ↑ 99.8 Ω; Fault: R12 or J");
  });
  it("says that there is no verdict when the rig was never learnt", () => {
    expect(foundWords(run({ verdict: "calibrating", findings: [] }), bench)).toBe("No verdict");
    expect(foundWords(run({ verdict: "nominal", findings: [] as Finding[] as never }), bench)).toBe(
      "No fault",
    );
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
