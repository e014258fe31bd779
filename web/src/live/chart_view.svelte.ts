import { SvelteSet } from "svelte/reactivity";
import type { Marker } from "../charts/chart_port";
import type { RenderLoop } from "../charts/render_loop";
import type { Viewport } from "../charts/viewport.svelte";
import type { Change, EstimatorName, EventKind, Story } from "../contract/types";
import type { Key } from "../i18n/catalogue";
import { t } from "../i18n/i18n.svelte";
import { announcer } from "../shell/announcer.svelte";
import type { Slide } from "../stream/slide";
import { ControlAccount } from "./control_account.svelte";
import { type CursorName, Cursors } from "./cursors.svelte";
import { ESTIMATORS, type EstimatorShape, type Family, primaryOf } from "./estimators";
import { Lens } from "./lens.svelte";
import type { RunModel } from "./run_model.svelte";

export type Tab = "swa" | "sia" | "models" | "methods" | "table";
const GROW_EVERY_MS = 500;
const AFTER_MARKER = 0.25;
const DEFAULT_SPAN_S = 20;
/** A review shows runs up to this length as a whole. */
const WHOLE_UNTIL_S = 60;
const BEFORE_ONSET = 0.25;
const HINT_MS = 2500;
const CURSOR_STEPS = 100;

/** The mark of an event in the charts; those of the story have the same there. */
export const MARK_OF: Partial<Record<EventKind, Marker["kind"]>> = {
  relay_confirmed: "fault",
  detected: "detected",
  isolated: "isolated",
  returned: "isolated",
  compensated: "compensated",
  compensation_ended: "compensated",
  trip: "trip",
  stopped: "stopped",
};
/** Events that the story does not have, and what their marks say. */
const MARKED: Partial<Record<EventKind, Key>> = {
  returned: "mark_returned",
  compensated: "event_compensated",
  compensation_ended: "event_compensation_ended",
  trip: "event_trip",
  stopped: "state_stopped",
};

/** The state that the charts of one screen share: view, markers, cursor, selected estimators. */
export class ChartView {
  tab = $state<Tab>("sia");
  /** The estimators of the lower charts, or of those before another tab was opened. */
  family = $state<Family>("sia");
  readonly shown = new SvelteSet<EstimatorName>(ESTIMATORS.map(({ name }) => name));
  /** Run time under the pointer. */
  hover = $state<number | null>(null);
  readonly cursors: Cursors;
  /** Spans that the answer of a blind trial points at. */
  evidence = $state.raw<[number, number][]>([]);
  /** Of a run under speed control. */
  readonly control: ControlAccount;
  readonly lens: Lens;
  /** The chart that the pointer is on or was last on. */
  pointed: HTMLElement | null = null;
  /** The user turned the wheel over a chart and may want to know how to zoom. */
  wheelHint = $state(false);
  /** The charts that a phone shows, by key. */
  chosen = $state.raw<[string, string]>(["input", "p0"]);
  /** Increases when the charts must adapt their ranges to all that is visible. */
  fits = $state(0);
  /** Increases when the charts may widen their ranges. */
  growths = $state(0);
  /** Number of the change that was chosen for the table of before and after. */
  chosenChange = $state<number | null>(null);
  private timer: ReturnType<typeof setInterval> | undefined;
  private marked = -1;
  private hintTimer: ReturnType<typeof setTimeout> | undefined;
  /** Run time under the pointer outside the lens. */
  private outside: number | null = null;

  constructor(
    readonly model: RunModel,
    readonly slide: Slide,
    readonly view: Viewport,
    readonly loop: RenderLoop,
  ) {
    this.cursors = new Cursors(slide);
    this.control = new ControlAccount(model.id);
    this.lens = new Lens(view, slide);
  }

  start(): void {
    this.timer = setInterval(() => {
      this.growths++;
    }, GROW_EVERY_MS);
  }

  stop(): void {
    clearInterval(this.timer);
    clearTimeout(this.hintTimer);
  }

  /** Run time up to which samples are drawn now. */
  edge(nowS = performance.now() / 1000): number {
    return this.view.pausedAt ?? this.model.shownTime(nowS);
  }

  openTab(tab: Tab): void {
    this.tab = tab;
    if (tab === "swa" || tab === "sia") this.family = tab;
  }

  /** Opens the table of samples, or goes back to the charts. */
  toggleTable(): void {
    this.openTab(this.tab === "table" ? this.family : "table");
  }

  primary(family: Family): EstimatorShape {
    return primaryOf(family, this.shown);
  }

  /** Shows a chart in place 0 or 1 of a phone; the other one gives way if it is the same. */
  choose(place: number, key: string): void {
    const [first, second] = this.chosen;
    if (place === 0) this.chosen = [key, key === second ? first : second];
    else this.chosen = [key === first ? second : first, key];
  }

  togglePause(): void {
    this.view.pausedAt = this.view.pausedAt === null ? this.edge() : null;
  }

  /** Whether the charts show what `follow` makes them show: the newest samples, or the whole run. */
  get following(): boolean {
    const { model, view } = this;
    if (!view.live || view.pausedAt !== null) return false;
    return model.running || view.span >= model.duration;
  }

  follow(): void {
    this.view.follow();
    if (!this.model.running) this.view.span = Math.max(this.model.duration, 1);
  }

  fit(): void {
    this.fits++;
  }

  /** The default view: the newest samples, or the whole of a run that is over. */
  reset(): void {
    this.follow();
    if (this.model.running) this.view.span = DEFAULT_SPAN_S;
    this.fit();
  }

  /** What is seen first of a run that is over: all of it, of a long one what is around its fault. */
  openReview(): void {
    const { view, model } = this;
    const untouched = view.live && view.pausedAt === null && view.span === DEFAULT_SPAN_S;
    if (!untouched) return;
    const onset = this.onset;
    if (onset === null || model.duration <= WHOLE_UNTIL_S) {
      this.follow();
      return;
    }
    const from = Math.max(0, onset - BEFORE_ONSET * DEFAULT_SPAN_S);
    this.show(from, from + DEFAULT_SPAN_S);
  }

  /** Shows `factor` times the span; a run that is over ends at its last sample. */
  zoom(factor: number, aroundS?: number): void {
    const { model, view } = this;
    view.zoom(factor, this.edge(), aroundS);
    if (!model.running) this.keepInRun();
  }

  show(fromS: number, toS: number): void {
    this.view.show(fromS, toS);
    if (!this.model.running) this.keepInRun();
  }

  private keepInRun(): void {
    const { model, view } = this;
    const length = Math.max(model.duration, 1);
    if (view.span >= length) this.follow();
    else view.left = Math.min(view.left, length - view.span);
  }

  /** The pointer is at this time; in the lens it must not move what the lens shows. */
  point(timeS: number | null, inLens: boolean): void {
    this.hover = timeS;
    if (!inLens) this.outside = timeS;
  }

  lensRange(edge: number): [number, number] {
    const first = this.model.running ? null : this.onset;
    return this.lens.range(edge, this.outside ?? this.cursors.newest ?? first);
  }

  hintAtWheel(): void {
    this.wheelHint = true;
    clearTimeout(this.hintTimer);
    this.hintTimer = setTimeout(() => {
      this.wheelHint = false;
    }, HINT_MS);
  }

  /** Sets or removes a cursor, at the pointer or in the middle of what is shown. */
  pinCursor(which: CursorName): void {
    const [from, to] = this.view.range(this.edge());
    const middle = (from + Math.min(to, this.edge())) / 2;
    const free = this.cursors.at(which) === null;
    this.cursors.set(which, free ? (this.hover ?? middle) : null);
  }

  /** Puts the cursors on the ends of what is shown. */
  selectView(): void {
    const [from, to] = this.view.range(this.edge());
    this.cursors.select(from, Math.min(to, this.edge()));
  }

  /** Moves the cursor that was set last: by samples, or by hundredths of the view. */
  moveCursor(steps: number, bySample: boolean): void {
    const step = bySample ? this.slide.period : this.view.span / CURSOR_STEPS;
    const moved = this.cursors.move(steps * step);
    if (moved) announcer.say("cursor", `${moved[0]} ${this.model.seconds(moved[1])} s`);
  }

  /** Moves the next marker, in time, to a quarter of the width from the left edge. */
  nextMarker(): void {
    const times = this.markers.filter((m) => m.kind !== "planned").map((m) => m.timeS);
    if (times.length === 0) return;
    this.marked = (this.marked + 1) % times.length;
    this.showTime(times[this.marked] as number);
  }

  showTime(timeS: number): void {
    const span = Math.min(this.view.span, 5);
    const from = Math.max(0, timeS - AFTER_MARKER * span);
    this.show(from, from + span);
  }

  private get story(): Story {
    return this.model.story;
  }

  /** When the rig was first not nominal: what is before it is healthy. */
  get onset(): number | null {
    return this.story.episodes[0]?.onset_s ?? null;
  }

  /** The change that the table of before and after is about: the last, or one that was chosen. */
  get change(): Change | null {
    const { changes } = this.story;
    return changes[this.chosenChange ?? changes.length - 1] ?? changes.at(-1) ?? null;
  }

  /** When the newest change was, whoever says so. */
  get lastOnset(): number | null {
    return this.story.change_times_s.at(-1) ?? null;
  }

  readonly markers: Marker[] = $derived.by(() => this.makeMarkers());

  private makeMarkers(): Marker[] {
    const { model } = this;
    const { bench } = model;
    const markers: Marker[] = [];
    const acted = new Set<string>();
    const { story } = this;
    for (const { component, value, at_s, nominal } of story.changes) {
      acted.add(component);
      const label = `${bench.change(component, value)}${bench.simulated(component) ? " SIM" : ""}`;
      markers.push({ kind: nominal ? "planned" : "fault", timeS: at_s, label });
    }
    for (const { detected_at_s, delay_s, isolated_at_s } of story.episodes.flatMap(
      (each) => each.detections,
    )) {
      const since = delay_s === null ? "" : ` +${model.seconds(delay_s)} s`;
      markers.push({ kind: "detected", timeS: detected_at_s, label: t("detected") + since });
      if (isolated_at_s === null) continue;
      markers.push({ kind: "isolated", timeS: isolated_at_s, label: t("event_isolated") });
    }
    for (const event of model.shownEvents) {
      const label = MARKED[event.kind];
      const kind = MARK_OF[event.kind];
      if (label && kind) markers.push({ kind, timeS: model.timeOf(event), label: t(label) });
    }
    for (const fault of model.running ? (model.run?.plan?.faults ?? []) : []) {
      if (acted.has(fault.component)) continue;
      markers.push({
        kind: "planned",
        timeS: fault.at_s ?? 0,
        label: bench.change(fault.component, fault.value),
      });
    }
    for (const [name, value] of Object.entries(model.faults.waiting)) {
      const label = bench.change(name, value);
      markers.push({ kind: "planned", timeS: model.faults.learningUntilS ?? 0, label });
    }
    const armed = model.faults.injection;
    if (armed) {
      const label = bench.change(armed.component, armed.value);
      markers.push({ kind: "planned", timeS: armed.atS, label });
    }
    const { a, b } = this.cursors;
    if (a !== null) markers.push({ kind: "cursorA", timeS: a, label: "" });
    if (b !== null) markers.push({ kind: "cursorB", timeS: b, label: "" });
    return markers.sort((a, b) => a.timeS - b.timeS);
  }
}
