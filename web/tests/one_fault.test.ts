import { afterEach, describe, expect, it, vi } from "vitest";
import { FaultCommands } from "../src/live/fault_commands.svelte";
import { oneFault, otherFault } from "../src/live/one_fault.svelte";
import { PlanModel } from "../src/live/plan_model.svelte";
import type { ClientMessage } from "../src/stream/messages";
import { ABOUT, bench, know, rigOf } from "./support/bench";

describe("one fault at a time", () => {
  it("is refused beside a component that is not nominal", () => {
    expect(otherFault("R12", ["R1"], [], 3)).toEqual({ components: ["R1"], coming: null });
    expect(otherFault("R1", ["R1"], [], 3)).toBeNull();
  });
  it("is refused before a fault of the plan, which comes in any case", () => {
    const planned = [{ component: "R1", value: 100, at_s: 10 }];
    expect(otherFault("R12", [], planned, 3)).toEqual({ components: ["R1"], coming: planned[0] });
    expect(otherFault("R1", [], planned, 3)).toBeNull();
    expect(otherFault("R12", [], planned, 12)).toBeNull(); // it was there and was taken back
  });
  it("is refused until an intermittent fault has come for the last time", () => {
    const planned = [
      { component: "R1", value: 100, at_s: 10, until_s: 15, kind: "intermittent" as const },
    ];
    expect(otherFault("R12", [], planned, 12)?.coming).toBe(planned[0]);
    expect(otherFault("R12", [], planned, 16)).toBeNull();
  });
});

describe("a change armed for later", () => {
  afterEach(() => void vi.useRealTimers());
  it("is asked again when its time comes", () => {
    vi.useFakeTimers();
    const sent: ClientMessage[] = [];
    const faults = new FaultCommands(bench, (message) => sent.push(message) > 0);
    let reason = "";
    faults.inject({ component: "R1", value: 100, atS: 10 }, 2, () => reason);
    reason = "R12 is not nominal";
    vi.advanceTimersByTime(2000);
    expect(sent).toEqual([]);
    expect(faults.shown.R1).toMatchObject({ state: "refused", reason });
    faults.reconsider();
    expect(faults.shown.R1).toMatchObject({ state: "refused", reason });
    reason = "";
    faults.reconsider();
    expect(faults.shown.R1).toMatchObject({ state: "nominal", reason: "" });
    faults.inject({ component: "R1", value: 100, atS: 14 }, 2, () => "");
    vi.advanceTimersByTime(2000);
    expect(sent).toMatchObject([{ action: "set", component: "R1", value: 100 }]);
  });
});

describe("a plan", () => {
  afterEach(() => {
    oneFault.on = true;
  });
  it("has one fault, or several when the box is not ticked, and again one when it is", () => {
    know([ABOUT], [rigOf("amp-1", true)]);
    const plan = new PlanModel();
    plan.pick("R12", 2000);
    expect(plan.faulty).toEqual(["R12"]);
    oneFault.on = false;
    plan.pick("J", 3e-5);
    expect(plan.faulty).toEqual(["R12", "J"]);
    oneFault.on = true;
    plan.keepOne();
    expect(plan.faults).toMatchObject([{ component: "J", value: 3e-5 }]);
  });
});
