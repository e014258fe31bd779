/** Seconds that a chart can show at once; the first is the default. */
export const WINDOWS_S = [20, 10, 5, 60, 600];
const SPAN_MIN_S = 0.2;

/**
 * The piece of run time on the screen, one for all charts. While `live`, it follows the newest
 * sample; panning or zooming lets it go, `follow` takes it up again.
 */
export class Viewport {
  live = $state(true);
  span = $state(20);
  left = $state(0);
  /** Run time at which the display was paused, null while it plays. */
  pausedAt = $state<number | null>(null);

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

  setSpan(span: number): void {
    this.span = span;
  }

  show(from: number, to: number): void {
    this.live = false;
    this.span = Math.max(SPAN_MIN_S, to - from);
    this.left = Math.max(0, from);
  }

  pan(share: number, edge: number): void {
    const [from] = this.range(edge);
    this.live = false;
    this.left = Math.max(0, from + share * this.span);
  }

  zoom(factor: number, edge: number): void {
    const [from, to] = this.range(edge);
    const centre = (from + to) / 2;
    const span = Math.min(600, Math.max(SPAN_MIN_S, (to - from) * factor));
    this.show(Math.max(0, centre - span / 2), Math.max(0, centre - span / 2) + span);
  }

  pause(at: number | null): void {
    this.pausedAt = at;
  }
}
