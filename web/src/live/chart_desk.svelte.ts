import { SvelteSet } from "svelte/reactivity";
import type { EstimatorName } from "../api/types";
import type { Marker } from "../charts/chart_port";
import type { RenderLoop } from "../charts/render_loop";
import type { Viewport } from "../charts/viewport.svelte";
import { t } from "../i18n/i18n.svelte";
import type { Slide } from "../stream/slide";
import { type EstimatorShape, type Family, primaryOf } from "./estimators";
import type { RunModel } from "./run_model.svelte";

export type Tab = "swa" | "sia" | "models";
const GROW_EVERY_MS = 500;
const AFTER_MARKER = 0.25;

/** The state that the charts of one screen share: view, markers, cursor, selected estimators. */
export class ChartDesk {
  tab = $state<Tab>("sia");
  readonly shown = new SvelteSet<EstimatorName>([
    "swa_50",
    "swa_100",
    "swa_200",
    "sia_20_5",
    "sia_100_20",
    "sia_500_20",
  ]);
  /** Run time under the pointer. */
  hover = $state<number | null>(null);
  cursorA = $state<number | null>(null);
  cursorB = $state<number | null>(null);
  /** Increases when the charts must adapt their ranges to all that is visible. */
  fits = $state(0);
  /** Increases when the charts may widen their ranges. */
  growths = $state(0);
  private timer: ReturnType<typeof setInterval> | undefined;
  private marked = -1;

  constructor(
    readonly model: RunModel,
    readonly slide: Slide,
    readonly view: Viewport,
    readonly loop: RenderLoop,
  ) {}

  start(): void {
    this.timer = setInterval(() => {
      this.growths++;
    }, GROW_EVERY_MS);
  }

  stop(): void {
    clearInterval(this.timer);
  }

  /** Run time up to which samples are drawn now. */
  edge(nowS = performance.now() / 1000): number {
    return this.view.pausedAt ?? this.model.shownTime(nowS);
  }

  get family(): Family {
    return this.tab === "swa" ? "swa" : "sia";
  }

  primary(family: Family): EstimatorShape {
    return primaryOf(family, this.shown);
  }

  togglePause(): void {
    this.view.pause(this.view.pausedAt === null ? this.edge() : null);
  }

  /** Whether the charts show what `follow` makes them show: the newest samples, or the whole run. */
  get following(): boolean {
    const { model, view } = this;
    return view.live && (model.running || view.span >= model.duration);
  }

  follow(): void {
    this.view.follow();
    if (!this.model.running) this.view.setSpan(Math.max(this.model.duration, 1));
  }

  fit(): void {
    this.fits++;
  }

  pinCursor(which: "A" | "B"): void {
    const [from, to] = this.view.range(this.edge());
    const at = this.hover ?? (from + to) / 2;
    if (which === "A") this.cursorA = this.cursorA === null ? at : null;
    else this.cursorB = this.cursorB === null ? at : null;
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
    this.view.show(
      Math.max(0, timeS - AFTER_MARKER * span),
      Math.max(0, timeS - AFTER_MARKER * span) + span,
    );
  }

  /** Run time of the first change of a component from its nominal value, according to the rig. */
  get faultTime(): number | null {
    const event = this.faultEvent;
    return event ? this.model.timeOf(event) : null;
  }

  get faultEvent() {
    return this.model.events.find(
      (event) =>
        event.kind === "relay_confirmed" &&
        event.component !== undefined &&
        typeof event.value === "number" &&
        !this.model.bench.isNominal(event.component, event.value),
    );
  }

  /** Time of the change for shading and tables: from the rig, otherwise the diagnosis' estimate. */
  get onset(): number | null {
    return (
      this.faultTime ?? this.model.verdict?.onset_s ?? this.model.verdict?.detected_at_s ?? null
    );
  }

  readonly markers: Marker[] = $derived.by(() => this.makeMarkers());

  private makeMarkers(): Marker[] {
    const { model } = this;
    const { bench } = model;
    const markers: Marker[] = [];
    const acted = new Set<string>();
    for (const event of model.events) {
      const timeS = model.timeOf(event);
      if (event.kind === "relay_confirmed" && event.component && event.value !== undefined) {
        const name = event.component;
        acted.add(name);
        const healthy = bench.isNominal(name, event.value);
        const label = `${bench.change(name, event.value)}${bench.simulated(name) ? " SIM" : ""}`;
        markers.push({ kind: healthy ? "planned" : "fault", timeS, label });
      } else if (event.kind === "detected") {
        const since = this.faultTime === null ? "" : ` +${model.seconds(timeS - this.faultTime)} s`;
        markers.push({ kind: "detected", timeS, label: t("mark_detected") + since });
      } else if (event.kind === "isolated") {
        markers.push({ kind: "isolated", timeS, label: t("mark_isolated") });
      } else if (event.kind === "returned") {
        markers.push({ kind: "isolated", timeS, label: t("mark_returned") });
      } else if (event.kind === "trip") {
        markers.push({ kind: "trip", timeS, label: t("mark_trip") });
      }
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
    if (this.cursorA !== null) markers.push({ kind: "cursorA", timeS: this.cursorA, label: "" });
    if (this.cursorB !== null) markers.push({ kind: "cursorB", timeS: this.cursorB, label: "" });
    return markers.sort((a, b) => a.timeS - b.timeS);
  }
}
