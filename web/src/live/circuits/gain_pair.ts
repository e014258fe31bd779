import type { Component } from "../../contract/types";
import type { Bench } from "../../plant/bench";

/** Two components that act on all that is measured by one gain, in the inverting amplifier. */
export class GainPair {
  private constructor(
    private readonly bench: Bench,
    /** In the input; a larger value lowers the gain. */
    readonly input: Component,
    /** In the feedback; a larger value raises the gain. */
    readonly feedback: Component,
  ) {}

  static of(bench: Bench): GainPair | null {
    if (bench.about.structure.name !== "inverting-amplifier") return null;
    const input = bench.componentOf("R9");
    const feedback = bench.componentOf("R12");
    return input && feedback ? new GainPair(bench, input, feedback) : null;
  }

  /** The resistors whose voltage depends on `input` alone. */
  readonly tap = ["R14", "R15"] as const;
  /** Symbols of the gain's formula: (feedback + tap) (1/input + 1/beside). */
  readonly beside = "R10";

  /** k, by the formula of the amplifier. */
  gain(input: number, feedback: number): number {
    return (feedback + this.tapOhm) * this.conductance(input);
  }

  /** Volts across `tap` for one volt of input: the current of the input flows through it. */
  tapGain(input: number): number {
    return this.tapOhm * this.conductance(input);
  }

  /** The feedback that gives this gain; below 0 there is none. */
  feedbackFor(gain: number, input: number): number {
    return gain / this.conductance(input) - this.tapOhm;
  }

  /** The input that gives this gain; null where none does. */
  inputFor(gain: number, feedback: number): number | null {
    const rest = gain / (feedback + this.tapOhm) - 1 / this.sheet(this.beside);
    return rest > 0 ? 1 / rest : null;
  }

  /** The gain that remains when the input part is an open circuit. */
  get gainMin(): number {
    return this.gain(Number.POSITIVE_INFINITY, this.bench.nominal(this.feedback));
  }

  private get tapOhm(): number {
    return this.tap.reduce((sum, symbol) => sum + this.sheet(symbol), 0);
  }

  private conductance(input: number): number {
    return 1 / input + 1 / this.sheet(this.beside);
  }

  private sheet(symbol: string): number {
    return this.bench.parameter(symbol)?.value ?? Number.NaN;
  }
}
