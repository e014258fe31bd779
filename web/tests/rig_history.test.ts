import { describe, expect, it } from "vitest";
import type { CheckStep, RigCheck, RigDay } from "../src/contract/types";
import { i18n } from "../src/i18n/i18n.svelte";
import { dayEnd, dayStart } from "../src/i18n/times";
import { checkReason, figureText, hoursOf } from "../src/lab/rig_history";

const step = (change: Partial<CheckStep>): CheckStep => ({
  step: "b0d",
  subject: "",
  passed: true,
  measured: null,
  low: null,
  high: null,
  unit: "",
  text: "",
  ...change,
});
const day = (change: Partial<RigDay>): RigDay => ({
  start: "2026-11-23T00:00:00Z",
  people_s: 0,
  jobs_s: 0,
  checks_s: 0,
  idle_s: 0,
  out_s: 0,
  ...change,
});

describe("history of a rig", () => {
  it("adds up the hours of the last days only", () => {
    const days = [day({ people_s: 36_000 }), day({ people_s: 3600 }), day({ out_s: 1800 })];
    expect(hoursOf(days, 2)).toEqual({ people: 1, jobs: 0, checks: 0, idle: 0, out: 0.5 });
    expect(hoursOf(days, 30).people).toBe(11);
  });
  it("gives the limits of a step, or what a contact should have shown", () => {
    expect(figureText(step({ measured: 1.3, low: 0.9, high: 1.1, unit: "1/V" }))).toEqual({
      measured: "1.300 1/V",
      allowed: "0.9000 … 1.100 1/V",
      expected: "",
    });
    const contact = figureText(step({ measured: 4.2, low: 5, high: 5, unit: "V" }));
    expect(contact.allowed).toBe("");
    expect(contact.expected).toMatch(/^5/);
    expect(figureText(step({}))).toEqual({ measured: "", allowed: "", expected: "" });
  });
  it("says in the reader's language by which step a check failed", async () => {
    await i18n.loadAll();
    const check: RigCheck = {
      id: 1,
      at: "2026-11-23T00:00:00Z",
      kind: "self_test",
      passed: false,
      reason: "gain is 1.3 of its norm",
      steps: [
        step({ step: "interlock" }),
        step({ step: "gain", passed: false, measured: 1.3, low: 0.9, high: 1.1, unit: "1/V" }),
      ],
    };
    expect(checkReason(check)).toBe("Gain: 1.300 1/V, allowed 0.9000 … 1.100 1/V");
    const relay = step({ step: "relay", subject: "R1 = 56, Do1", passed: false, text: "reads 0" });
    expect(checkReason({ ...check, steps: [relay] })).toBe(
      "Relay read back, R1 = 56, Do1: reads 0",
    );
    expect(checkReason({ ...check, steps: [] })).toBe(check.reason);
  });
  it("searches whole days", () => {
    expect(dayStart("")).toBe("");
    expect(Date.parse(dayEnd("2026-11-23")) - Date.parse(dayStart("2026-11-23"))).toBe(86_400_000);
  });
});
