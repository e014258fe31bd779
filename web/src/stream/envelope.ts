/** Samples in a bucket of each level; a bucket holds whole buckets of the level before. */
const BUCKETS = [8, 16, 32, 64, 128, 256, 512, 1024];
/** A level of fewer buckets saves nothing. */
const BUCKETS_LEAST = 16;

/** Two points for each bucket of `bucket` samples: its lowest and its highest value. */
export interface Level {
  bucket: number;
  time: Float64Array;
  columns: Float32Array[];
}

/**
 * Lowest and highest values of columns of samples, in ever longer buckets: what a chart draws when
 * many samples share a pixel. Half the memory of the columns, and a drawing costs what the
 * chart is wide, not what the run is long. NaN is left out; a bucket of NaN alone is NaN.
 */
export class Envelope {
  readonly levels: Level[];

  constructor(
    private readonly columns: readonly Float32Array[],
    capacity: number,
  ) {
    const worth = BUCKETS.filter((bucket) => capacity >= bucket * BUCKETS_LEAST);
    this.levels = worth.map((bucket) => {
      const points = 2 * Math.ceil(capacity / bucket);
      return {
        bucket,
        time: new Float64Array(points),
        columns: columns.map(() => new Float32Array(points)),
      };
    });
  }

  /** Samples move by multiples of this only, so that buckets stay whole. */
  get grain(): number {
    return this.levels.at(-1)?.bucket ?? 1;
  }

  /** The coarsest level that has a bucket for every `samples` samples; none when they are few. */
  at(samples: number): Level | undefined {
    return this.levels.findLast((level) => level.bucket <= samples);
  }

  /** Slots [from, to) have changed; slots from `held` on hold nothing. */
  update(from: number, to: number, held: number): void {
    let below: Level | undefined;
    for (const level of this.levels) {
      const first = Math.floor(from / level.bucket);
      const last = Math.ceil(to / level.bucket);
      const source = below ? below.columns : this.columns;
      // two points of the level below stand for one of its buckets
      const each = below ? (2 * level.bucket) / below.bucket : level.bucket;
      const end = below ? 2 * Math.ceil(held / below.bucket) : held;
      const buckets = { first, last, each, end };
      for (let channel = 0; channel < source.length; channel++) {
        reduce(source[channel] as Float32Array, level.columns[channel] as Float32Array, buckets);
      }
      below = level;
    }
  }

  /** The samples moved `slots` towards the front. */
  shift(slots: number): void {
    for (const level of this.levels) {
      for (const column of level.columns) column.copyWithin(0, (2 * slots) / level.bucket);
    }
  }

  /** The sample in the first slot is at run time `baseS`. */
  fillTime(baseS: number, periodS: number): void {
    for (const level of this.levels) {
      const half = (level.bucket * periodS) / 2;
      for (let at = 0; at < level.time.length; at++) level.time[at] = baseS + at * half;
    }
  }
}

interface Buckets {
  first: number;
  last: number;
  /** Values of the source in a bucket. */
  each: number;
  /** Values of the source that are there. */
  end: number;
}

function reduce(from: Float32Array, to: Float32Array, { first, last, each, end }: Buckets): void {
  for (let bucket = first; bucket < last; bucket++) {
    let low = Number.POSITIVE_INFINITY;
    let high = Number.NEGATIVE_INFINITY;
    const stop = Math.min(end, (bucket + 1) * each);
    for (let at = bucket * each; at < stop; at++) {
      const value = from[at] as number;
      if (value < low) low = value;
      if (value > high) high = value;
    }
    to[2 * bucket] = low <= high ? low : Number.NaN;
    to[2 * bucket + 1] = low <= high ? high : Number.NaN;
  }
}
