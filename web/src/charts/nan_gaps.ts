/**
 * Where a curve has no value between two that it has: from and to, in units of `x`. Of equal values
 * of `x` (an envelope has two at each) the first counts.
 */
export function nanGaps(
  x: ArrayLike<number>,
  y: ArrayLike<number | null | undefined>,
  first: number,
  last: number,
): [number, number][] {
  const gaps: [number, number][] = [];
  let before = -1;
  for (let at = first; at <= last; at++) {
    if (!Number.isFinite(y[at])) continue;
    if (before >= 0 && at > before + 1) gaps.push([x[before] as number, x[at] as number]);
    before = at;
  }
  return gaps;
}

/** Where no curve has a value: `columns` are x and the curves. */
export function emptySpans([x, ...curves]: ArrayLike<number | null | undefined>[]) {
  const times = (x ?? []) as ArrayLike<number>;
  const any = new Float32Array(times.length).fill(Number.NaN);
  for (const curve of curves)
    for (let at = 0; at < times.length; at++) if (Number.isFinite(curve[at])) any[at] = 0;
  return nanGaps(times, any, 0, times.length - 1);
}
