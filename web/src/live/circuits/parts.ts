import type { Component } from "../../contract/types";
import { formatQuantity } from "../../i18n/quantity";
import type { Bench, ChannelName } from "../../plant/bench";
import type { Settings } from "../positions";

/** A parameter of a structure as a drawing shows it. */
export interface Part {
  /** Its component's name if it has one, else its own. */
  label: string;
  /** Of a component; of other parts `meaning` says it. */
  value: string;
  /** "fixed": no component of this bench, its fault is not known. */
  state: "fixed" | "nominal" | "faulty";
  component?: Component;
  /** For people. */
  meaning: string;
}

/** What a drawing asks of the bench that it draws. */
export class Parts {
  constructor(
    private readonly bench: Bench,
    private readonly settings: Settings,
    /** Called with the component under the pointer. */
    readonly choose: (component: Component | null) => void,
  ) {}

  /** @param symbol  a parameter of the structure; undefined when this bench has no such part (0) */
  of(symbol: string): Part | undefined {
    const component = this.bench.componentOf(symbol);
    const sheet = this.bench.parameter(symbol);
    if (component !== undefined) return this.ofComponent(component, sheet?.meaning);
    if (!sheet || sheet.value === 0) return undefined;
    return {
      label: symbol,
      value: "",
      state: "fixed",
      meaning: `${symbol} ${formatQuantity(sheet.unit, sheet.value)}, ${sheet.meaning}`,
    };
  }

  ofComponent(component: Component, meaning = ""): Part {
    const value = this.actual(component);
    return {
      label: component,
      value: this.bench.format(component, value),
      state: this.bench.isNominal(component, value) ? "nominal" : "faulty",
      component,
      meaning,
    };
  }

  /** The value that the rig has confirmed. */
  actual(component: Component): number {
    return this.settings[component]?.actual ?? this.bench.nominal(component);
  }

  measures(channel: ChannelName): boolean {
    return this.bench.about.channels[channel].exists;
  }

  /** Components that a drawing with these places for parameters has no place for. */
  without(places: readonly string[]): Component[] {
    const drawn = new Set(places.map((symbol) => this.bench.componentOf(symbol)));
    return this.bench.symbols.filter((component) => !drawn.has(component));
  }
}
