import { SvelteMap } from "svelte/reactivity";
import type { Component, Excitation, Fault, FaultKind, RunPlan, RunRequest } from "../api/types";
import { LEARNING_S, NOMINAL, sameValue } from "../plant/components";

export type ExcitationKind = "prbs" | "step" | "multisine" | "chirp";

/** The experiment that the next press of "run" makes. As new it is the paper's. */
export class PlanModel {
  readonly values = new SvelteMap<Component, number>();
  rig = $state("");
  atS = $state(10);
  durationS = $state(20);
  kind = $state<FaultKind>("abrupt");
  untilS = $state(15);
  excitation = $state<ExcitationKind>("prbs");
  lowV = $state(2);
  highV = $state(3);
  fromHz = $state(0.5);
  toHz = $state(20);
  lines = $state(20);
  seed = $state(1);
  name = $state("");
  /** Id of a saved fault set; the sliders are not used then. */
  faultSet = $state("");

  static paper(): PlanModel {
    const plan = new PlanModel();
    plan.set("R1", 100);
    return plan;
  }

  static from(source: RunPlan | undefined): PlanModel {
    const plan = new PlanModel();
    const fault = source?.faults?.[0];
    for (const each of source?.faults ?? []) plan.set(each.component, each.value);
    if (fault) {
      plan.atS = fault.at_s ?? 0;
      plan.kind = fault.kind ?? "abrupt";
      if (fault.until_s) plan.untilS = fault.until_s;
    }
    plan.durationS = source?.duration_s ?? 20;
    return plan;
  }

  value(component: Component): number {
    return this.values.get(component) ?? NOMINAL[component];
  }

  set(component: Component, value: number): void {
    if (sameValue(value, NOMINAL[component])) this.values.delete(component);
    else this.values.set(component, value);
  }

  /** One fault at a time, as the paper. */
  only(component: Component, value: number): void {
    this.values.clear();
    this.set(component, value);
  }

  get faults(): Fault[] {
    return [...this.values].map(([component, value]) => ({
      component,
      value,
      at_s: this.atS,
      ...(this.kind === "abrupt" ? {} : { kind: this.kind, until_s: this.untilS }),
    }));
  }

  /** The fault comes while the healthy rig is learnt: such a run has no diagnosis. */
  get tooEarly(): boolean {
    return !this.faultSet && this.values.size > 0 && this.atS < LEARNING_S;
  }

  request(): RunRequest {
    return {
      ...(this.rig ? { rig: this.rig } : {}),
      excitation: this.excitationRequest(),
      duration_s: this.durationS,
      ...(this.faultSet ? { fault_set: Number(this.faultSet) } : { faults: this.faults }),
      seed: this.seed,
      ...(this.name ? { name: this.name } : {}),
    };
  }

  private excitationRequest(): Excitation {
    const offset_v = (this.lowV + this.highV) / 2;
    const amplitude_v = (this.highV - this.lowV) / 2;
    switch (this.excitation) {
      case "prbs":
        return {
          kind: "prbs",
          low_v: this.lowV,
          high_v: this.highV,
          clock_s: 0.01,
          seed: this.seed,
        };
      case "step":
        return { kind: "step", low_v: this.lowV, high_v: this.highV, at_s: 1 };
      case "multisine":
        return { kind: "multisine", offset_v, amplitude_v, lines: this.lines, seed: this.seed };
      case "chirp":
        return { kind: "chirp", offset_v, amplitude_v, from_hz: this.fromHz, to_hz: this.toHz };
    }
  }
}
