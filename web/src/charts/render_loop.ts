/** Redraw rates per second, from the best to the slowest. */
export const RATES = [60, 30, 15, 5] as const;
const SLOW_FRAME_MS = 34;
const SLOW_FOR_MS = 3000;
const FAST_AGAIN_MS = 15000;
const WINDOW = 120;

export interface Drawable {
  /** Draws if something has changed. `now` in seconds. */
  draw(now: number): void;
}

/**
 * One requestAnimationFrame loop for all charts of a page. When frames take too long (95th
 * percentile above 34 ms for 3 s) it draws less often, 60, 30, 15, 5 times a second, and reports
 * the rate. The recording is not affected.
 */
export class RenderLoop {
  private readonly drawables = new Set<Drawable>();
  private readonly costs: number[] = [];
  private level = 0;
  private slowSince = Number.NaN;
  private fastSince = Number.NaN;
  private lastDraw = Number.NEGATIVE_INFINITY;
  private lastFrame = Number.NaN;
  private handle = 0;

  constructor(private readonly onRate: (redrawsPerSecond: number) => void = () => {}) {}

  add(drawable: Drawable): () => void {
    this.drawables.add(drawable);
    return () => this.drawables.delete(drawable);
  }

  start(): void {
    if (this.handle !== 0) return;
    const step = (now: number) => {
      this.handle = requestAnimationFrame(step);
      this.frame(now);
    };
    this.handle = requestAnimationFrame(step);
  }

  stop(): void {
    cancelAnimationFrame(this.handle);
    this.handle = 0;
    this.lastFrame = Number.NaN;
  }

  get rate(): number {
    return RATES[this.level] as number;
  }

  /** One animation frame at `now` milliseconds. */
  frame(now: number): void {
    if (!Number.isNaN(this.lastFrame)) this.judge(now - this.lastFrame, now);
    this.lastFrame = now;
    if (now - this.lastDraw < 1000 / this.rate - 4) return;
    this.lastDraw = now;
    for (const drawable of this.drawables) drawable.draw(now / 1000);
  }

  private judge(interval: number, now: number): void {
    if (interval > 1000) {
      this.costs.length = 0; // the tab was hidden
      return;
    }
    this.costs.push(interval);
    if (this.costs.length > WINDOW) this.costs.shift();
    if (this.costs.length < WINDOW / 2) return;
    const sorted = [...this.costs].sort((a, b) => a - b);
    const slow = (sorted[Math.floor(sorted.length * 0.95)] as number) > SLOW_FRAME_MS;
    if (slow) {
      this.fastSince = Number.NaN;
      if (Number.isNaN(this.slowSince)) this.slowSince = now;
      if (now - this.slowSince > SLOW_FOR_MS) this.setLevel(this.level + 1);
    } else {
      this.slowSince = Number.NaN;
      if (Number.isNaN(this.fastSince)) this.fastSince = now;
      if (now - this.fastSince > FAST_AGAIN_MS) this.setLevel(this.level - 1);
    }
  }

  private setLevel(level: number): void {
    const bounded = Math.min(RATES.length - 1, Math.max(0, level));
    this.slowSince = Number.NaN;
    this.fastSince = Number.NaN;
    this.costs.length = 0;
    if (bounded === this.level) return;
    this.level = bounded;
    this.onRate(this.rate);
  }
}
