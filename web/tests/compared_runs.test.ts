import { expect, it } from "vitest";
import { ESTIMATORS, type EstimatorShape } from "../src/live/estimators";
import { afterLastChange, comparedIds } from "../src/pages/compared_runs";
import { Slide } from "../src/stream/slide";
import { block } from "./support/blocks";
import { change, NOTHING } from "./support/stories";

const PERIOD = 0.01;
const shown = ESTIMATORS.find((each) => each.name === "sia_100_20") as EstimatorShape;
/** Its parameters are 1 for 10 s, rise while the window fills, then are 2. */
const slide = new Slide(2000, PERIOD);
slide.append(block(0, 2000, (_, index) => Math.min(2, Math.max(1, 1 + (index - 1000) / 119))));
const changed = (atS: number) => ({
  ...NOTHING,
  changes: [change("R1", 100, atS)],
  change_times_s: [atS],
  set_back: false,
});

it("a compared run has the means after its last change that its own page has", () => {
  expect(afterLastChange(slide, changed(10), shown)).toEqual([2, 2, 2]);
  expect(afterLastChange(slide, changed(19.5), shown)).toEqual([null, null, null]);
  expect(afterLastChange(slide, NOTHING, shown)).toEqual([2, 2, 2]);
});

it("an address that names a run twice compares it once", () => {
  const ids = (query: string) => comparedIds(new URLSearchParams(query));
  expect(ids("runs=a,b,a")).toEqual(["a", "b"]);
  expect(ids("runs=a&runs=b,,a")).toEqual(["a", "b"]);
  expect(ids("runs=a,a,b,c,d,e")).toEqual(["a", "b", "c", "d"]);
  expect(ids("")).toEqual([]);
});
