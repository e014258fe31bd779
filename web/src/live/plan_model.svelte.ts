import { SvelteMap } from "svelte/reactivity";
import type {
  Component,
  Excitation,
  Fault,
  FaultKind,
  Rig,
  RunPlan,
  RunRequest,
} from "../api/types";
import type { Bench } from "../plant/bench";
import { rigs } from "../shell/rigs.svelte";

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
    plan.values.set("R1", 100);
    return plan;
  }

  static from(source: RunPlan | undefined): PlanModel {
    const plan = new PlanModel();
    const fault = source?.faults?.[0];
    for (const each of source?.faults ?? []) plan.values.set(each.component, each.value);
    if (fault) {
      plan.atS = fault.at_s ?? 0;
      plan.kind = fault.kind ?? "abrupt";
      if (fault.until_s) plan.untilS = fault.until_s;
    }
    plan.durationS = source?.duration_s ?? 20;
    return plan;
  }

  /** The rig that takes the plan, if it is there; one that is not named is a simulated one. */
  get target(): Rig | undefined {
    return rigs.find(this.rig) ?? rigs.list.find((rig) => rig.kind === "simulated");
  }

  /** Not before the rigs are known. */
  get bench(): Bench | undefined {
    return rigs.benchOf(this.target);
  }

  value(component: Component): number {
    return this.values.get(component) ?? this.bench?.nominal(component) ?? Number.NaN;
  }

  set(component: Component, value: number): void {
    if (this.bench?.isNominal(component, value)) this.values.delete(component);
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

  /** Run time until which the healthy rig is learnt. */
  get learningS(): number {
    return this.bench?.learningS ?? 0;
  }

  /** The fault comes while the healthy rig is learnt: such a run has no diagnosis. */
  get tooEarly(): boolean {
    return !this.faultSet && this.values.size > 0 && this.atS < this.learningS;
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
