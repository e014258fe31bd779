import type { Component, Rig, Schemas } from "../api/types";

/** Same setting, as far as float32 and JSON can say; no value is like none. */
export function sameValue(a: number | null | undefined, b: number): boolean {
  if (a === null || a === undefined) return false;
  return Math.abs(a - b) <= 1e-6 * Math.max(Math.abs(a), Math.abs(b));
}

/** What the server says of a bench. Every number of its components that the page shows is from here. */
export class Bench {
  constructor(readonly about: Schemas["Bench"]) {}

  /** Those that can be changed on this rig. */
  components(rig: Rig | undefined): Component[] {
    const all = rig?.capabilities.motor_faults ?? false;
    return this.symbols.filter((component) => all || !this.simulated(component));
  }

  get symbols(): Component[] {
    return this.about.components.map((part) => part.symbol);
  }

  /** NaN of a component that this bench does not have. */
  nominal(component: Component): number {
    return this.part(component)?.nominal ?? Number.NaN;
  }

  isNominal(component: Component, value: number | null | undefined): boolean {
    return sameValue(value, this.nominal(component));
  }

  /** The values that can be set, the nominal one first. */
  values(component: Component): number[] {
    return this.part(component)?.values.map((each) => each.value) ?? [];
  }

  /** The relay line that connects this value. */
  line(component: Component, value: number): string | null {
    const found = this.part(component)?.values.find((each) => sameValue(value, each.value));
    return found?.line ?? null;
  }

  /** Simulators alone can change it. */
  simulated(component: Component): boolean {
    return this.part(component)?.switched_by === "simulator";
  }

  /** Which parameters of the model it moves: "b0, b1". */
  moves(component: Component): string {
    return this.part(component)?.moves.join(", ") ?? "";
  }

  /** What was published about this fault, if that experiment was made. */
  published(component: Component, value: number) {
    return this.about.published?.faults.find(
      (fault) => fault.component === component && sameValue(fault.value, value),
    );
  }

  /** Run time until which a run learns its healthy rig. */
  get learningS(): number {
    return this.about.healthy.to_s;
  }

  private part(component: Component) {
    return this.about.components.find((part) => part.symbol === component);
  }
}
