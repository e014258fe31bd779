import { describe, expect, it } from "vitest";
import { type AnswerDraft, answerOf } from "../src/course/answer_draft";
import { duePreset, poolOf } from "../src/course/pool";

const draft: AnswerDraft = {
  component: "R1",
  value: 56,
  confidence: 70,
  text: "why",
  evidence: [[8.2, 9]],
};

describe("the answer of a trial", () => {
  it("has the value in the unit of the component", () => {
    expect(answerOf(draft, "ohm")).toEqual({
      component: "R1",
      value: 56,
      unit: "ohm",
      confidence: 0.7,
      text: "why",
      evidence: [{ from_s: 8.2, to_s: 9 }],
    });
    expect(answerOf({ ...draft, atS: 8.2 }, "ohm")).toMatchObject({ at_s: 8.2 });
  });
  it("says that the rig is healthy without a value", () => {
    expect(answerOf({ ...draft, component: "healthy" }, "")).toEqual({
      component: null,
      confidence: 0.7,
      text: "why",
      evidence: [{ from_s: 8.2, to_s: 9 }],
    });
  });
  it("is none while something is missing", () => {
    expect(answerOf({ ...draft, component: "" }, "")).toBeNull();
    expect(answerOf({ ...draft, value: undefined }, "ohm")).toBeNull();
    expect(answerOf({ ...draft, value: Number.NaN }, "ohm")).toBeNull();
    expect(answerOf({ ...draft, value: 0 }, "ohm")).toBeNull();
  });
});

describe("a new exercise", () => {
  it("has an item for each part", () => {
    const pool = poolOf([{ component: "R1", values: [10, 56] }], {
      fromS: 8,
      toS: 12,
      healthyShare: 0.2,
    });
    expect(pool).toEqual({
      items: [{ component: "R1", values: [10, 56], onset_from_s: 8, onset_to_s: 12 }],
      healthy_share: 0.2,
    });
  });
  it("may have faults that come slowly, or come and go", () => {
    const times = { fromS: 8, toS: 8, healthyShare: 0, kind: "drift", lastsS: 4 } as const;
    expect(poolOf([{ component: "R1", values: [56] }], times).items[0]).toMatchObject({
      kind: "drift",
      lasts_s: 4,
    });
  });
  it("is due in a week, over the end of a month", () => {
    expect(duePreset(new Date(2026, 1, 25, 15))).toBe("2026-03-04T23:59");
  });
});
