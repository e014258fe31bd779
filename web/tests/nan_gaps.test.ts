import { expect, it } from "vitest";
import { emptySpans, nanGaps } from "../src/charts/nan_gaps";

const N = Number.NaN;
const gaps = (...y: number[]) => nanGaps([...y.keys()], Float32Array.from(y), 0, y.length - 1);

it("a curve is not drawn over what is not known", () => {
  expect(gaps(1, 2, 3)).toEqual([]);
  expect(gaps(1, N, N, 2, N, 3)).toEqual([
    [0, 3],
    [3, 5],
  ]);
  expect(gaps(N, N, 1, 2, N)).toEqual([]); // its ends are no gaps
  expect(nanGaps([0, 1, 2, 3], [1, N, N, 2], 1, 3)).toEqual([]); // of what is seen
});

it("a time is hatched in which no curve has a value", () => {
  expect(
    emptySpans([[0, 1, 2, 3, 4], Float32Array.of(1, N, N, N, 2), [1, 2, null, null, 3]]),
  ).toEqual([[1, 4]]);
  expect(emptySpans([[]])).toEqual([]);
});
