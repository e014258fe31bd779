const DELAY_S = 0.1;
const DELAY_SAMPLES = 2;

/** Frames wait this long before they are drawn, so that jitter on the way does not show. */
export function playoutDelayS(periodS: number): number {
  return Math.max(DELAY_S, DELAY_SAMPLES * (periodS || 0));
}
const FORGET_PER_S = 0.002;

/**
 * Run time shown by the charts: the server's clock minus the playout delay. The offset between
 * the clocks is that of the quickest frame so far, which is slowly forgotten (2 ms a second), so
 * that one early frame does not determine it for ever.
 */
export class PlayoutClock {
  constructor(private readonly delayS: () => number = () => DELAY_S) {}

  private offset = Number.NaN;
  private observedAt = 0;
  private frozenAt = Number.NaN;

  /** A frame sent at run time `serverTime` arrived at local time `now` (seconds). */
  observe(serverTime: number, now: number): void {
    const offset = serverTime - now;
    const held = this.offset - FORGET_PER_S * (now - this.observedAt);
    this.offset = Number.isNaN(this.offset) || offset > held ? offset : held;
    this.observedAt = now;
    this.frozenAt = Number.NaN;
  }

  /** The run ended: the time stays at its last sample. */
  freeze(runTime: number): void {
    this.frozenAt = runTime;
  }

  /** Run time up to which charts are drawn, at local time `now`. */
  time(now: number): number {
    if (!Number.isNaN(this.frozenAt)) return this.frozenAt;
    return Number.isNaN(this.offset) ? 0 : now + this.offset - this.delayS();
  }

  /** Run time at the rig, without the playout delay. */
  rigTime(now: number): number {
    if (!Number.isNaN(this.frozenAt)) return this.frozenAt;
    return Number.isNaN(this.offset) ? 0 : now + this.offset;
  }
}
