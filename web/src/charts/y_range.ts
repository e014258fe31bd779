/** A range that ends on round numbers, with a small margin around [low, high]. */
export function niceRange(low: number, high: number): [number, number] {
  const span = Math.max(high - low, Math.abs(high) * 1e-3, 1e-9);
  const pad = span * 0.12;
  const step = niceStep((span + 2 * pad) / 5);
  return [Math.floor((low - pad) / step) * step, Math.ceil((high + pad) / step) * step];
}

function niceStep(rough: number): number {
  const power = 10 ** Math.floor(Math.log10(rough));
  const digit = rough / power;
  return power * (digit <= 1 ? 1 : digit <= 2 ? 2 : digit <= 2.5 ? 2.5 : digit <= 5 ? 5 : 10);
}

/** Lowest and highest of the central `share` of the finite values in `columns`[from, to). */
export function spread(
  columns: Float32Array[],
  from: number,
  to: number,
  share = 0.98,
): [number, number] | null {
  const values: number[] = [];
  const step = Math.max(1, Math.floor((to - from) / 2000));
  for (const column of columns) {
    for (let slot = from; slot < to; slot += step) {
      const value = column[slot] as number;
      if (Number.isFinite(value)) values.push(value);
    }
  }
  if (values.length === 0) return null;
  values.sort((a, b) => a - b);
  const tail = (1 - share) / 2;
  const at = (p: number) => values[Math.round(p * (values.length - 1))] as number;
  return [at(tail), at(1 - tail)];
}

/** Of a range of which less than this share is used, most is empty. */
const USED_LEAST = 0.4;

/** `range`, or that of the data alone when they use little of it. */
export function narrowed(range: [number, number], low: number, high: number): [number, number] {
  const used = (high - low) / (range[1] - range[0]);
  return used < USED_LEAST ? niceRange(low, high) : range;
}

/** What may stick out of a range, as a share of it, before the range grows: about half a line. */
const TOLERANCE = 0.005;

/**
 * Extends `range` on the side where [low, high], the bulk of what is shown, or the median of one of
 * the signals exceeds it. A range never shrinks automatically, and leaves room when it grows, so
 * noise moves it once at most.
 */
export function grown(
  range: [number, number],
  low: number,
  high: number,
  medians: number[] = [],
): [number, number] {
  const slack = TOLERANCE * (range[1] - range[0]);
  const below = low < range[0] - slack || medians.some((median) => median < range[0]);
  const above = high > range[1] + slack || medians.some((median) => median > range[1]);
  if (!below && !above) return range;
  const [from, to] = niceRange(
    Math.min(range[0], low, ...medians),
    Math.max(range[1], high, ...medians),
  );
  return [below ? from : range[0], above ? to : range[1]];
}

/** Of the finite values in each of `columns`[from, to). */
export function mediansOf(columns: Float32Array[], from: number, to: number): number[] {
  return columns.flatMap((column) => spread([column], from, to, 0)?.[0] ?? []);
}
