/** A pause of the page's ticks of more than this was sleep. */
const SLEPT_S = 1;

/**
 * How old the newest samples are, in the page's seconds. While the page's timers sleep it reads
 * nothing: that time does not count as the rig's silence, and samples that were late before are
 * still late.
 */
export class SampleAge {
  private tickedAt: number;

  constructor(private heardAt: number) {
    this.tickedAt = heardAt;
  }

  heard(atS: number): void {
    this.heardAt = atS;
  }

  /** To be asked at every tick. */
  at(nowS: number): number {
    const sleptS = nowS - this.tickedAt;
    if (sleptS > SLEPT_S) this.heardAt = Math.min(nowS, this.heardAt + sleptS);
    this.tickedAt = nowS;
    return nowS - this.heardAt;
  }
}
