import type { Slide } from "../stream/slide";

export interface Moments {
  mean: number;
  deviation: number;
  count: number;
}

/** Mean and standard deviation of a channel over run time [from, to), NaN left out. */
export function moments(slide: Slide, channel: number, fromS: number, toS: number): Moments | null {
  const first = Math.max(slide.first, Math.ceil(fromS / slide.period - 1e-9));
  const last = Math.min(slide.end, Math.ceil(toS / slide.period - 1e-9));
  if (last <= first) return null;
  const start = slide.slot(first);
  const column = slide.columns[channel]?.subarray(start, start + last - first) ?? [];
  let count = 0;
  let sum = 0;
  for (const value of column) {
    if (!Number.isFinite(value)) continue;
    count++;
    sum += value;
  }
  if (count === 0) return null;
  const mean = sum / count;
  let squares = 0;
  for (const value of column) {
    if (Number.isFinite(value)) squares += (value - mean) ** 2;
  }
  return { mean, deviation: count > 1 ? Math.sqrt(squares / (count - 1)) : 0, count };
}

/** Spans of run time without samples. */
export function gapSpans(slide: Slide): [number, number][] {
  const spans: [number, number][] = [];
  if (slide.missing === 0) return spans;
  let from = -1;
  for (let index = slide.first; index <= slide.end; index++) {
    const missing = index < slide.end && slide.isMissing(slide.slot(index));
    if (missing && from < 0) from = index;
    if (!missing && from >= 0) {
      spans.push([(from - 1) * slide.period, index * slide.period]);
      from = -1;
    }
  }
  return spans;
}
