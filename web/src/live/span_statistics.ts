import type { Slide } from "../stream/slide";

/** Of the finite samples of a channel over a span of run time. */
export interface SpanStatistics {
  count: number;
  mean: number;
  /** Sample standard deviation (n - 1); 0 of a single sample. */
  deviation: number;
  min: number;
  max: number;
  /** Least-squares line: its slope per second, and its value at the mean time of the samples. */
  slope: number;
  /** Run time at which the line has the value `mean`. */
  centreS: number;
}

/**
 * Statistics and the straight line y = mean + slope (t - centre) that fits best in the sense of
 * least squares, over the samples with fromS <= t <= toS. Samples that are NaN are left out. The
 * slope of fewer than two samples is NaN.
 * @returns null if there is no sample
 */
export function spanStatistics(
  slide: Slide,
  channel: number,
  fromS: number,
  toS: number,
): SpanStatistics | null {
  const { period } = slide;
  const first = Math.max(slide.first, Math.ceil(fromS / period - 1e-6));
  const last = Math.min(slide.end, Math.floor(toS / period + 1e-6) + 1);
  const column = slide.columns[channel];
  if (last <= first || !column) return null;
  const start = slide.slot(first);
  const values = column.subarray(start, start + last - first);
  let count = 0;
  let sum = 0;
  let places = 0;
  let min = Number.POSITIVE_INFINITY;
  let max = Number.NEGATIVE_INFINITY;
  for (let at = 0; at < values.length; at++) {
    const value = values[at] as number;
    if (!Number.isFinite(value)) continue;
    count++;
    sum += value;
    places += at;
    if (value < min) min = value;
    if (value > max) max = value;
  }
  if (count === 0) return null;
  const mean = sum / count;
  const centre = places / count;
  let squares = 0;
  let spread = 0;
  let product = 0;
  for (let at = 0; at < values.length; at++) {
    const value = values[at] as number;
    if (!Number.isFinite(value)) continue;
    squares += (value - mean) ** 2;
    spread += (at - centre) ** 2;
    product += (value - mean) * (at - centre);
  }
  return {
    count,
    mean,
    deviation: count > 1 ? Math.sqrt(squares / (count - 1)) : 0,
    min,
    max,
    slope: count > 1 ? product / spread / period : Number.NaN,
    centreS: (first + centre) * period,
  };
}

/** The unit of a slope of a quantity of that unit: "V/s". */
export function slopeUnit(unit: string): string {
  const [over, under] = unit.split("/");
  if (under === undefined) return `${unit}/s`;
  if (over === under) return "1/s";
  return over?.endsWith("·s") ? `${over.slice(0, -2)}/${under}` : `${over}/(${under}·s)`;
}
