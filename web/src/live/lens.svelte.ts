import type { Viewport } from "../charts/viewport.svelte";
import type { Slide } from "../stream/slide";

/** A second at 100 Hz. */
const SAMPLES = 100;
const KEY = "faultlab.lens";

/** A short part of what the charts show, drawn wide: a fast input fills a long view as a block. */
export class Lens {
  shown = $state(globalThis.localStorage?.getItem(KEY) !== "off");

  constructor(
    private readonly view: Viewport,
    private readonly slide: Slide,
  ) {}

  get spanS(): number {
    return SAMPLES * this.slide.period;
  }

  toggle(): void {
    this.shown = !this.shown;
    localStorage.setItem(KEY, this.shown ? "on" : "off");
  }

  /**
   * [from, to] in run time that it shows: around `centreS` if the charts show that time, else the
   * newest. `edge` is the newest sample that they show.
   */
  range(edge: number, centreS: number | null): [number, number] {
    const [from, to] = this.view.range(edge);
    const newest = Math.min(edge, to);
    const seen = centreS !== null && centreS >= from && centreS <= newest;
    const right = seen ? Math.min(newest, centreS + this.spanS / 2) : newest;
    const left = Math.max(0, right - this.spanS);
    return [left, left + this.spanS];
  }
}
