import { Envelope } from "./envelope";
import { CHANNELS, ESTIMATORS, type SampleBlock, STATUS_NOT_EXCITED } from "./frame";

const FIRST_ESTIMATE = 5;
/** Samples are moved to the front once in so many, at most. */
const SPARE_MAX = 16_384;

/**
 * The newest `window` samples of a run, one typed array per channel, and their envelope.
 * Each column has room for more: samples are appended, and when the end is reached the newest window
 * moves to the front. So the samples stay contiguous, `view` hands out subarrays and nothing is
 * allocated while a run goes on. Missing samples are NaN. A late sample (replayed after a reconnect)
 * goes to its own place. An estimate that must not be used (not excited, invalid) is NaN.
 */
export class Slide {
  readonly time: Float64Array;
  readonly columns: Float32Array[];
  /** Rises with every change; a chart that has drawn it is clean. */
  version = 0;
  /** Samples that precede a received index and are not (yet) here. */
  missing = 0;
  /** Index of the newest sample + 1. */
  end = 0;

  private readonly capacity: number;
  private readonly envelope: Envelope;
  private base = 0; // index of the sample in slot 0
  private readonly seen: Uint8Array;

  constructor(
    readonly window: number,
    readonly period: number,
  ) {
    this.capacity = window + Math.min(window, SPARE_MAX);
    this.time = new Float64Array(this.capacity);
    this.columns = Array.from({ length: CHANNELS }, () => new Float32Array(this.capacity));
    this.seen = new Uint8Array(this.capacity);
    this.envelope = new Envelope(this.columns, this.capacity);
    this.fillTime();
  }

  /** Index of the oldest sample stored. */
  get first(): number {
    return Math.max(this.base, this.end - this.window);
  }

  /** Index of the first sample that is not here. */
  get firstMissing(): number {
    if (this.missing === 0) return this.end;
    for (let index = this.first; index < this.end; index++) {
      if (this.isMissing(this.slot(index))) return index;
    }
    return this.end;
  }

  append(block: SampleBlock): void {
    for (let row = 0; row < block.count; row++) this.put(block.firstIndex + row, block, row);
    const from = Math.max(this.base, block.firstIndex) - this.base;
    const to = block.firstIndex + block.count - this.base;
    if (to > from) this.envelope.update(from, to, this.end - this.base);
    this.version++;
  }

  /** Slot of sample `index` in `columns`, or -1 if it is not stored. */
  slot(index: number): number {
    return index >= this.base && index < this.end ? index - this.base : -1;
  }

  /** Slots [from, to) of the samples with from_s <= t <= to_s, one more on each side. */
  range(fromS: number, toS: number): [number, number] {
    const first = Math.max(this.first, Math.floor(fromS / this.period) - 1);
    const last = Math.min(this.end, Math.ceil(toS / this.period) + 2);
    if (last <= first) return [0, 0];
    return [first - this.base, last - this.base];
  }

  /**
   * Channels over [fromS, toS], time first, to draw where `perPixel` samples share a pixel: the
   * samples themselves, or the lowest and highest of every few.
   */
  view(
    fromS: number,
    toS: number,
    channels: readonly number[],
    perPixel: number,
  ): [Float64Array, ...Float32Array[]] {
    const [first, last] = this.range(fromS, toS);
    const level = this.envelope.at(perPixel);
    const { time, columns } = level ?? this;
    const from = level ? 2 * Math.floor(first / level.bucket) : first;
    const to = level ? 2 * Math.ceil(last / level.bucket) : last;
    return [
      time.subarray(from, to),
      ...channels.map((channel) => (columns[channel] as Float32Array).subarray(from, to)),
    ];
  }

  value(channel: number, index: number): number {
    const slot = this.slot(index);
    return slot < 0 ? Number.NaN : (this.columns[channel]?.[slot] ?? Number.NaN);
  }

  isMissing(slot: number): boolean {
    return this.seen[slot] === 0;
  }

  private put(index: number, block: SampleBlock, row: number): void {
    if (index < this.base) return; // older than all samples stored
    if (index >= this.end) this.extendTo(index);
    const slot = index - this.base;
    if (this.seen[slot] === 0) {
      this.seen[slot] = 1;
      this.missing--;
    }
    const from = row * CHANNELS;
    for (let channel = 0; channel < CHANNELS; channel++) {
      (this.columns[channel] as Float32Array)[slot] = block.values[from + channel] as number;
    }
    for (let estimator = 0; estimator < ESTIMATORS; estimator++) {
      const status = block.status[row * 8 + estimator] as number;
      if (status >= STATUS_NOT_EXCITED) {
        for (let p = 0; p < 3; p++) {
          const column = this.columns[FIRST_ESTIMATE + 3 * estimator + p] as Float32Array;
          column[slot] = Number.NaN;
        }
      }
    }
  }

  /** Makes room so that `index` becomes the newest sample; the samples between are missing. */
  private extendTo(index: number): void {
    if (index - this.base >= this.capacity) this.slideTo(index);
    const from = this.end - this.base;
    const to = index + 1 - this.base;
    if (to - from > 1) {
      for (const column of this.columns) column.fill(Number.NaN, from, to);
      this.envelope.update(from, to, to);
    }
    this.seen.fill(0, from, to);
    this.missing += to - from;
    this.end = index + 1;
  }

  private slideTo(index: number): void {
    const { grain } = this.envelope;
    const whole = (slots: number) => Math.floor(slots / grain) * grain;
    const keepFrom = this.base + whole(Math.max(0, index - this.window - this.base));
    const held = this.end - this.base;
    if (keepFrom > this.end) {
      this.missing += keepFrom - this.end; // a gap longer than the window
      this.base = keepFrom;
      this.end = keepFrom;
    } else {
      const shift = keepFrom - this.base;
      for (const column of this.columns) column.copyWithin(0, shift, held);
      this.seen.copyWithin(0, shift, held);
      this.base = keepFrom;
      this.envelope.shift(shift);
    }
    this.fillTime();
  }

  private fillTime(): void {
    for (let slot = 0; slot < this.capacity; slot++) {
      this.time[slot] = (this.base + slot) * this.period;
    }
    this.envelope.fillTime(this.base * this.period, this.period);
  }
}
