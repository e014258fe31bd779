import { onDestroy } from "svelte";
import { get, queryOf } from "../api/client";
import type { Component, Schemas } from "../contract/types";
import { wordsOf } from "../i18n/words";
import type { Bench } from "../plant/bench";

export type Signals = Schemas["Demonstration"];
export type Estimates = Schemas["DemonstrationEstimates"];
export type Detection = Schemas["DemonstrationDetection"];

/** A slider asks when it has stood still for so long. */
const PAUSE_MS = 80;

/**
 * The address of a study of a bench. @param part  "", "/estimates" or "/detection"
 * @param changes  components and their values; nominal ones are left out
 */
export function studyPath(
  bench: Bench,
  part: "" | "/estimates" | "/detection",
  changes: [Component, number][],
  settings: Record<string, string | number> = {},
): string {
  const acting = changes.filter(([component, value]) => !bench.isNominal(component, value));
  const query = queryOf({ changes: acting.map((each) => each.join(":")).join(","), ...settings });
  return `/benches/${encodeURIComponent(bench.id)}/demonstration${part}${query}`;
}

/** The answer to the newest question; the one before stays until it is here. */
export class Study<T> {
  answer = $state.raw<T | null>(null);
  failure = $state("");
  private path = "";
  private asking: AbortController | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;

  ask(path: string): void {
    if (path === this.path) return;
    const first = this.path === "";
    this.path = path;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.fetch(path), first ? 0 : PAUSE_MS);
  }

  constructor() {
    onDestroy(() => {
      clearTimeout(this.timer);
      this.asking?.abort();
    });
  }

  private async fetch(path: string): Promise<void> {
    this.asking?.abort();
    const asking = new AbortController();
    this.asking = asking;
    try {
      const answer = await get<T>(path, asking.signal);
      if (this.path !== path) return;
      this.answer = answer;
      this.failure = "";
    } catch (error) {
      if (asking.signal.aborted) return;
      this.failure = wordsOf(error);
    }
  }
}

/** Columns of a chart; `periodS` apart from `fromS` on, null becomes a gap. */
export function columns(fromS: number, periodS: number, ...series: (number | null)[][]) {
  const length = Math.max(...series.map((each) => each.length));
  return {
    x: Float64Array.from({ length }, (_, at) => fromS + at * periodS),
    y: series.map((each) => Float32Array.from(each, (value) => value ?? Number.NaN)),
  };
}

/** The change that the demonstrations show: the first component at the first of its other values. */
export function shownFault(bench: Bench): [Component, number][] {
  const [component] = bench.symbols;
  const value = component === undefined ? undefined : bench.values(component)[1];
  return component === undefined || value === undefined ? [] : [[component, value]];
}
