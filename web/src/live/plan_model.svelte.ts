import type {
  Component,
  Controller,
  Excitation,
  Fault,
  FaultKind,
  ReferenceShape,
  Rig,
  Run,
  RunRequest,
  SpeedControl,
} from "../contract/types";
import type { Bench } from "../plant/bench";
import { type ExcitationKind, kindOf, levelsOf } from "../plant/excitation";
import { benches } from "../shell/benches.svelte";
import { rigs } from "../shell/rigs.svelte";
import { oneFault } from "./one_fault.svelte";

type Values = Record<Component, number>;

/**
 * The first experiment on a bench: its own excitation, and its first component at the last of its
 * values. The healthy rig is learnt for a quarter of it, and half of it is healthy.
 */
function firstOn(bench: Bench) {
  const { excitation, run, period_s: periodS } = bench.about;
  const [component] = bench.symbols;
  const value = component === undefined ? undefined : bench.values(component).at(-1);
  const values: Values =
    component === undefined || value === undefined ? {} : { [component]: value };
  const [lowV, highV] = levelsOf(excitation);
  return {
    values,
    durationS: Math.min(run.max_s, Math.max(run.min_s, 4 * bench.learningS)),
    excitation: kindOf(excitation),
    lowV,
    highV,
    fromHz: Number((0.005 / periodS).toPrecision(3)),
    toHz: Number((0.2 / periodS).toPrecision(3)),
  };
}

/** A field of a plan: what was chosen for the bench that it has now, else that bench's own. */
class Choice<T> {
  private chosen = $state.raw<{ bench: Bench; value: T } | null>(null);

  constructor(
    private readonly bench: () => Bench | undefined,
    private readonly own: (bench: Bench) => T,
    private readonly none: T,
  ) {}

  get value(): T {
    const bench = this.bench();
    if (!bench) return this.none;
    return this.chosen?.bench === bench ? this.chosen.value : this.own(bench);
  }
  set value(value: T) {
    const bench = this.bench();
    if (bench) this.chosen = { bench, value };
  }
}

const USUAL_SEED = 1;

/**
 * The experiment that the next press of "run" makes. What nobody has chosen is that of the bench's
 * first experiment; a choice is for one bench, and does not count when a rig of another one is
 * chosen. Nothing can be chosen before the bench is known.
 */
export class PlanModel {
  /** Its id; empty: a simulated one. */
  rig = $state("");
  /** Of the excitation; one that somebody chose is that of a simulator's noise, too. */
  seed = $state(USUAL_SEED);
  name = $state("");
  /** Otherwise the run starts with what was learnt of its rig in the last hour. */
  learnAnew = $state(false);
  readonly values = this.choice<Values>((first) => first.values, {});
  readonly durationS = this.choice((first) => first.durationS, 0);
  readonly atS = this.choice((first) => first.durationS / 2, 0);
  readonly untilS = this.choice((first) => (first.durationS * 3) / 4, 0);
  readonly kind = this.choice<FaultKind>(() => "abrupt", "abrupt");
  readonly excitation = this.choice<ExcitationKind>((first) => first.excitation, "prbs");
  readonly lowV = this.choice((first) => first.lowV, 0);
  readonly highV = this.choice((first) => first.highV, 0);
  readonly fromHz = this.choice((first) => first.fromHz, 0);
  readonly toHz = this.choice((first) => first.toHz, 0);
  readonly lines = this.choice(() => 20, 20);
  /** How the speed is to go; empty: no speed control. */
  readonly shape = this.choice<ReferenceShape | "">(() => "", "");
  readonly controller = this.choice<Controller>(() => "compensated", "compensated");
  readonly lowSpeed = this.usualControl("low_rad_s");
  readonly highSpeed = this.usualControl("high_rad_s");
  readonly holdS = this.usualControl("hold_s");
  /** Id of a saved fault set; the sliders are not used then. */
  readonly faultSet = this.choice(() => "", "");

  /** @param benchId  that of a plan without a rig; null is the server's first */
  constructor(private readonly benchId: string | null = null) {}

  /** The next run after this one: the same bench, faults and length. */
  static after(run: Pick<Run, "bench" | "plan"> | null): PlanModel {
    const plan = new PlanModel(run?.bench);
    const faults = run?.plan.faults ?? [];
    plan.values.value = Object.fromEntries(faults.map((fault) => [fault.component, fault.value]));
    if (run?.plan.duration_s) plan.durationS.value = run.plan.duration_s;
    const [fault] = faults;
    if (fault) {
      plan.atS.value = fault.at_s ?? 0;
      plan.kind.value = fault.kind ?? "abrupt";
      if (fault.until_s) plan.untilS.value = fault.until_s;
    }
    const { reference, controller } = run?.plan.control ?? {};
    if (reference) {
      plan.shape.value = reference.shape ?? "steps";
      if (controller) plan.controller.value = controller;
      if (reference.low_rad_s) plan.lowSpeed.value = reference.low_rad_s;
      if (reference.high_rad_s) plan.highSpeed.value = reference.high_rad_s;
      if (reference.hold_s) plan.holdS.value = reference.hold_s;
    }
    return plan;
  }

  /** The rig for the plan, if it exists; without a name it is a simulated rig. */
  get target(): Rig | undefined {
    return rigs.find(this.rig) ?? rigs.simulated(this.bench);
  }

  get faulty(): Component[] {
    return Object.keys(this.values.value);
  }

  value(component: Component): number {
    return this.values.value[component] ?? this.bench?.nominal(component) ?? Number.NaN;
  }

  set(component: Component, value: number): void {
    const { [component]: _, ...others } = this.values.value;
    const nominal = this.bench?.isNominal(component, value);
    this.values.value = nominal ? others : { ...others, [component]: value };
  }

  only(component: Component, value: number): void {
    this.values.value = {};
    this.set(component, value);
  }

  /** As the setting "one fault at a time" has it. */
  pick(component: Component, value: number): void {
    if (oneFault.on) this.only(component, value);
    else this.set(component, value);
  }

  /** Of several faults the one that was chosen last stays. */
  keepOne(): void {
    const last = Object.entries(this.values.value).at(-1);
    if (last) this.only(...last);
  }

  get faults(): Fault[] {
    return Object.entries(this.values.value).map(([component, value]) => ({
      component,
      value,
      at_s: this.atS.value,
      ...(this.kind.value === "abrupt"
        ? {}
        : { kind: this.kind.value, until_s: this.untilS.value }),
    }));
  }

  /** Run time at which the calibration of the healthy rig ends. */
  get learningS(): number {
    return this.bench?.learningS ?? 0;
  }

  /** The fault comes during the calibration: such a run has no diagnosis. */
  get tooEarly(): boolean {
    return !this.faultSet.value && this.faulty.length > 0 && this.atS.value < this.learningS;
  }

  /** What the rig of this plan can be asked to keep; null: it controls no speed. */
  get speedRange(): { reachable_rad_s: number } | null {
    return this.target?.capabilities.controls_speed ? (this.bench?.about.control ?? null) : null;
  }

  /** As the charts have it, in rpm behind the gear; plans have rad/s of the motor. */
  get lowRpm(): number {
    return this.rpm(this.lowSpeed.value);
  }
  set lowRpm(rpm: number) {
    this.lowSpeed.value = rpm / this.rpmPerRadS;
  }
  get highRpm(): number {
    return this.rpm(this.highSpeed.value);
  }
  set highRpm(rpm: number) {
    this.highSpeed.value = rpm / this.rpmPerRadS;
  }
  get rpmMost(): number {
    return Math.floor(this.rpmPerRadS * (this.speedRange?.reachable_rad_s ?? 0));
  }

  request(): RunRequest {
    return {
      ...(this.rig ? { rig: this.rig } : { bench: this.bench?.id }),
      excitation: this.excitationRequest(),
      control: this.controlRequest(),
      duration_s: this.durationS.value,
      ...(this.faultSet.value
        ? { fault_set: Number(this.faultSet.value) }
        : { faults: this.faults }),
      ...(this.seed === USUAL_SEED ? {} : { seed: this.seed }),
      ...(this.learnAnew ? {} : { learn: "if_needed" as const }),
      ...(this.name ? { name: this.name } : {}),
    };
  }

  /** Undefined until it is known. */
  get bench(): Bench | undefined {
    const named = rigs.find(this.rig);
    if (named) return benches.find(named.bench);
    return this.benchId === null ? benches.first : benches.find(this.benchId);
  }

  private get rpmPerRadS(): number {
    return this.bench?.rpmPerRadS ?? 1;
  }

  private rpm(radS: number): number {
    return Number((this.rpmPerRadS * radS).toPrecision(4));
  }

  private usualControl(name: "low_rad_s" | "high_rad_s" | "hold_s"): Choice<number> {
    return new Choice(
      () => this.bench,
      (bench) => bench.about.control?.[name] ?? 0,
      0,
    );
  }

  private controlRequest(): SpeedControl | undefined {
    const shape = this.shape.value;
    if (!shape || !this.speedRange) return undefined;
    return {
      reference: {
        shape,
        low_rad_s: this.lowSpeed.value,
        high_rad_s: this.highSpeed.value,
        hold_s: this.holdS.value,
      },
      controller: this.controller.value,
    };
  }

  private choice<T>(own: (first: ReturnType<typeof firstOn>) => T, none: T): Choice<T> {
    return new Choice(
      () => this.bench,
      (bench) => own(firstOn(bench)),
      none,
    );
  }

  excitationRequest(): Excitation {
    const offset_v = (this.lowV.value + this.highV.value) / 2;
    const amplitude_v = (this.highV.value - this.lowV.value) / 2;
    const { seed } = this;
    switch (this.excitation.value) {
      case "prbs":
        return {
          ...this.ownPrbs,
          kind: "prbs",
          low_v: this.lowV.value,
          high_v: this.highV.value,
          seed,
        };
      case "step":
        return { kind: "step", low_v: this.lowV.value, high_v: this.highV.value, at_s: 1 };
      case "multisine":
        return { kind: "multisine", offset_v, amplitude_v, lines: this.lines.value, seed };
      case "chirp":
        return {
          kind: "chirp",
          offset_v,
          amplitude_v,
          from_hz: this.fromHz.value,
          to_hz: this.toHz.value,
        };
    }
  }

  /** Clock and order of the bench's own sequence, which suit its motor. */
  private get ownPrbs() {
    const own = this.bench?.about.excitation;
    if (!own || (own.kind !== "prbs" && own.kind !== undefined)) return {};
    return { clock_s: own.clock_s, order: own.order };
  }
}
