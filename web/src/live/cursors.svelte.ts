import type { Segment } from "../charts/chart_port";

export type CursorName = "A" | "B";

/** Where cursors can stand: on samples first .. end - 1, `period` seconds apart. */
export interface Samples {
  readonly period: number;
  readonly first: number;
  readonly end: number;
}

/** Two cursors on the samples, the span between them, and the lines fitted to it. */
export class Cursors {
  a = $state<number | null>(null);
  b = $state<number | null>(null);
  /** Clicks place cursors, and dragging selects the span between them. */
  on = $state(false);
  /** By channel. */
  fitted = $state.raw<Partial<Record<number, Segment>>>({});
  private active: CursorName = "A";

  constructor(private readonly samples: Samples) {}

  at(which: CursorName): number | null {
    return which === "A" ? this.a : this.b;
  }

  /** Run time of the cursor that was set last. */
  get newest(): number | null {
    return this.at(this.active);
  }

  /** Places a cursor on the sample nearest to `timeS`, or removes it. */
  set(which: CursorName, timeS: number | null): void {
    const { period, first, end } = this.samples;
    const last = Math.max(first, end - 1);
    const at =
      timeS === null ? null : Math.min(last, Math.max(first, Math.round(timeS / period))) * period;
    this.on = true;
    this.active = which;
    if (which === "A") this.a = at;
    else this.b = at;
  }

  /** A click: the first sets A, the second B, another one moves the nearer. */
  pick(timeS: number): void {
    if (this.a === null) this.set("A", timeS);
    else if (this.b === null) this.set("B", timeS);
    else this.set(this.nearer(timeS), timeS);
  }

  select(fromS: number, toS: number): void {
    this.set("A", fromS);
    this.set("B", toS);
  }

  /** Moves the cursor that was set last; @returns its name and time, null if there is none. */
  move(byS: number): [CursorName, number] | null {
    const at = this.newest;
    if (at === null) return null;
    const { period } = this.samples;
    this.set(this.active, at + Math.sign(byS) * Math.max(period, Math.abs(byS)));
    return [this.active, this.newest ?? at];
  }

  /** The cursor within `reachS` of a time. */
  grip(timeS: number, reachS: number): CursorName | null {
    const nearer = this.nearer(timeS);
    return this.distance(nearer, timeS) <= reachS ? nearer : null;
  }

  /** [from, to] between the cursors, if both are set apart. */
  get span(): [number, number] | null {
    const { a, b } = this;
    return a === null || b === null || a === b ? null : [Math.min(a, b), Math.max(a, b)];
  }

  toggle(): void {
    this.on = !this.on;
    if (this.on) return;
    this.a = null;
    this.b = null;
    this.fitted = {};
  }

  private nearer(timeS: number): CursorName {
    return this.distance("A", timeS) <= this.distance("B", timeS) ? "A" : "B";
  }

  private distance(which: CursorName, timeS: number): number {
    const at = this.at(which);
    return at === null ? Number.POSITIVE_INFINITY : Math.abs(at - timeS);
  }
}
