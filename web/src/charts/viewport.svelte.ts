/** Seconds that a chart can show at once; the first is the default. */
export const WINDOWS_S = [20, 10, 5, 2, 1, 60, 600];
const SPAN_SAMPLES_MIN = 20;
const SPAN_MAX_S = 600;

/**
 * The interval of run time on the screen, the same for all charts. While `live`, it follows the
 * newest sample; panning or zooming stops this, `follow` starts it again.
 */
export class Viewport {
  live = $state(true);
  span = $state(WINDOWS_S[0] as number);
  left = $state(0);
  /** Run time at which the display was paused, null while it plays. */
  pausedAt = $state<number | null>(null);

  private readonly spanMin: number;

  constructor(periodS: number) {
    this.spanMin = SPAN_SAMPLES_MIN * periodS;
  }

  /** [from, to] in run time, when the newest sample shown is at `edge`. */
  range(edge: number): [number, number] {
    if (!this.live) return [this.left, this.left + this.span];
    const right = Math.max(this.span, edge);
    return [right - this.span, right];
  }

  follow(): void {
    this.live = true;
    this.pausedAt = null;
  }

  show(from: number, to: number): void {
    this.live = false;
    this.span = Math.min(SPAN_MAX_S, Math.max(this.spanMin, to - from));
    this.left = Math.max(0, from);
  }

  pan(share: number, edge: number): void {
    const [from] = this.range(edge);
    this.live = false;
    this.left = Math.max(0, from + share * this.span);
  }

  /** Shows `factor` times the span; the time `aroundS` stays where it is on the screen. */
  zoom(factor: number, edge: number, aroundS?: number): void {
    const [from, to] = this.range(edge);
    const around = aroundS ?? (from + to) / 2;
    const span = Math.min(SPAN_MAX_S, Math.max(this.spanMin, (to - from) * factor));
    const left = around - ((around - from) / (to - from)) * span;
    this.show(Math.max(0, left), Math.max(0, left) + span);
  }
}
