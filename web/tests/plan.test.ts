import { describe, expect, it } from "vitest";
import type { Run } from "../src/contract/types";
import { PlanModel } from "../src/live/plan_model.svelte";
import { ABOUT, DRIVER, know, rigOf } from "./support/bench";

const both = () =>
  know(
    [ABOUT, DRIVER],
    [rigOf("amp-1", true), rigOf("drv-1", true, DRIVER), rigOf("amp-2", false)],
  );

describe("a new plan", () => {
  it("is the first experiment of the server's first bench, in its own terms", () => {
    both();
    expect(new PlanModel().request()).toEqual({
      bench: ABOUT.id,
      excitation: { kind: "prbs", low_v: 2, high_v: 3, clock_s: 0.04, seed: 1 },
      duration_s: 28,
      faults: [{ component: "R1", value: 220, at_s: 14 }],
      learn: "if_needed",
    });
  });

  it("fixes the noise only with a seed that somebody chose", () => {
    both();
    const plan = new PlanModel();
    expect(plan.request().seed).toBeUndefined();
    plan.seed = 7;
    expect(plan.request().seed).toBe(7);
  });

  it("learns the rig anew only when it is told to", () => {
    both();
    const plan = new PlanModel();
    plan.learnAnew = true;
    expect(plan.request().learn).toBeUndefined();
  });

  it("keeps a speed only where the rig can, with the bench's own reference", () => {
    both();
    const plan = new PlanModel();
    expect(plan.request().control).toBeUndefined();
    plan.shape.value = "ramp";
    plan.highSpeed.value = 180;
    const control = plan.request().control;
    expect(control).toEqual({
      reference: { shape: "ramp", low_rad_s: 130, high_rad_s: 180, hold_s: 2 },
      controller: "compensated",
    });
    const next = PlanModel.after({ bench: ABOUT.id, plan: { control: { ...control } } });
    expect(next.request().control).toEqual(control);
    plan.rig = "drv-1"; // its bench measures no speed
    plan.shape.value = "steps";
    expect(plan.request().control).toBeUndefined();
  });

  it("asks for nothing before the bench is known, and then keeps what is chosen", () => {
    know([]);
    const plan = new PlanModel();
    expect(plan.faults).toEqual([]);
    expect(plan.bench).toBeUndefined();
    both();
    plan.durationS.value = 40;
    plan.set("J", 3e-5);
    both(); // the list of rigs came again
    expect(plan.durationS.value).toBe(40);
    expect(plan.faults.map((fault) => fault.component)).toEqual(["R1", "J"]);
    plan.only("R12", 2000);
    expect(plan.faults).toEqual([{ component: "R12", value: 2000, at_s: 14 }]);
    plan.set("R12", 4700);
    expect(plan.faults).toEqual([]);
  });

  it("becomes the first experiment of another bench with a rig of that", () => {
    both();
    const plan = new PlanModel();
    plan.durationS.value = 40;
    plan.only("R12", 2000);
    plan.faultSet.value = "7";
    plan.rig = "amp-2"; // the same bench: what was chosen stays
    expect(plan.durationS.value).toBe(40);
    plan.rig = "drv-1";
    expect(plan.request()).toEqual({
      rig: "drv-1",
      excitation: { kind: "multisine", offset_v: 1.5, amplitude_v: 0.5, lines: 20, seed: 1 },
      duration_s: 12,
      faults: [{ component: "Disc", value: 2.2e-5, at_s: 6 }],
      learn: "if_needed",
    });
    expect([plan.fromHz.value, plan.toHz.value]).toEqual([5, 200]);
    plan.excitation.value = "prbs"; // the clock of another kind says nothing
    expect(plan.request().excitation).toEqual({ kind: "prbs", low_v: 1, high_v: 2, seed: 1 });
  });

  it("stays within what a run of its bench may last", () => {
    know([{ ...DRIVER, id: "slow", healthy: { from_s: 0, to_s: 400 } }]);
    expect(new PlanModel().durationS.value).toBe(600);
  });
});

describe("the next plan after a run", () => {
  const run = {
    bench: DRIVER.id,
    plan: {
      duration_s: 33,
      faults: [{ component: "k", value: 2, at_s: 5, kind: "drift", until_s: 9 }],
    },
  } as Run;

  it("is on the run's bench, with its faults", () => {
    both();
    const plan = PlanModel.after(run);
    expect(plan.bench?.title).toBe(DRIVER.title);
    expect(plan.request()).toMatchObject({
      bench: DRIVER.id,
      duration_s: 33,
      faults: [{ component: "k", value: 2, at_s: 5, kind: "drift", until_s: 9 }],
    });
  });

  it("has no rig where none of its bench is left", () => {
    know([ABOUT, DRIVER], [rigOf("amp-1", true)]);
    expect(PlanModel.after(run).target).toBeUndefined();
  });

  it("is healthy after a healthy run", () => {
    both();
    expect(PlanModel.after({ bench: ABOUT.id, plan: { faults: [] } }).faults).toEqual([]);
  });
});
