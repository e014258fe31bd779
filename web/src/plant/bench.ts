import type { Component, Rig, Schemas } from "../contract/types";
import { formatQuantity, formatTick, formatWithSigma } from "../i18n/quantity";

export type ChannelName = keyof Schemas["Bench"]["channels"];
export const CHANNEL_NAMES: readonly ChannelName[] = ["um", "ua", "ia", "n"];

/**
 * Whether two values are the same within the precision of float32 and JSON; a missing value
 * equals none.
 */
export function sameValue(a: number | null | undefined, b: number): boolean {
  if (a === null || a === undefined) return false;
  return Math.abs(a - b) <= 1e-6 * Math.max(Math.abs(a), Math.abs(b));
}

/** What the server says of a bench. Every name and number of one that the page shows is from here. */
export class Bench {
  constructor(readonly about: Schemas["Bench"]) {}

  get id(): string {
    return this.about.id;
  }

  /** The speed on the charts, behind the gear, for one rad/s of the motor. */
  get rpmPerRadS(): number {
    return 60 / (2 * Math.PI * this.about.gear_ratio);
  }

  get title(): string {
    return this.about.title;
  }

  /** Those that can be changed on this rig. */
  components(rig: Rig | undefined): Component[] {
    const all = rig?.capabilities.motor_faults ?? false;
    return this.symbols.filter((component) => all || !this.simulated(component));
  }

  get symbols(): Component[] {
    return this.about.components.map((part) => part.symbol);
  }

  /** NaN for a component that this bench does not have. */
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

  /** Whether only simulators can change it. */
  simulated(component: Component): boolean {
    return this.part(component)?.switched_by === "simulator";
  }

  /** The parameters of the model that it changes: "b0, b1". */
  moves(component: Component): string {
    return this.part(component)?.moves.join(", ") ?? "";
  }

  /** "100 Ω" */
  format(component: Component, value: number | null | undefined, digits = 3): string {
    return formatQuantity(this.unit(component), value, digits);
  }

  /** "99.6 ± 0.4 Ω" */
  formatWithSigma(component: Component, value: number | null, sigma?: number | null): string {
    return formatWithSigma(this.unit(component), value, sigma);
  }

  formatTick(component: Component, value: number): string {
    return formatTick(this.unit(component), value, this.nominal(component));
  }

  /** "R1 → 100 Ω" for a fault of the component R1. */
  change(component: Component, value: number | null | undefined): string {
    return `${component} → ${this.format(component, value)}`;
  }

  /** The component that is this parameter of the structure, if its fault is known. */
  componentOf(parameter: string): Component | undefined {
    return this.about.components.find((part) => part.changes === parameter)?.symbol;
  }

  /** A parameter of the structure as the data sheet has it. */
  parameter(symbol: string) {
    return this.about.parameters.find((each) => each.symbol === symbol);
  }

  /** What was published about this fault, if that experiment was made. */
  published(component: Component, value: number) {
    return this.about.published?.faults.find(
      (fault) => fault.component === component && sameValue(fault.value, value),
    );
  }

  /** The channels that this bench measures and, if it is here, this rig too. */
  channels(rig?: Rig): ChannelName[] {
    const its = rig?.bench === this.id ? rig.capabilities : undefined;
    return CHANNEL_NAMES.filter(
      (name) => this.about.channels[name].exists && (its?.[name] ?? true),
    );
  }

  /** In which its estimates of this parameter are drawn. */
  estimateRange(parameter: string): [number, number] {
    const ranges: Partial<Record<string, number[]>> = this.about.estimate_ranges;
    const [from = 0, to = 1] = ranges[parameter] ?? [];
    return [from, to];
  }

  /** Run time until which a run learns its healthy rig. */
  get learningS(): number {
    return this.about.healthy.to_s;
  }

  /** SI, as its description names it. */
  unit(component: Component): string {
    return this.part(component)?.unit ?? "";
  }

  private part(component: Component) {
    return this.about.components.find((part) => part.symbol === component);
  }
}
