import type { Slide } from "../stream/slide";
import type { EstimatorShape } from "./estimators";
import { PARAMETERS, settleS } from "./estimators";
import { moments } from "./statistics";

const BEFORE_S = 5;
const BEFORE_SAMPLES = 100;
/** The rig itself settles after its start. */
const START_S = 0.5;

export interface BeforeAfterRow {
  name: string;
  before: number | null;
  after: number | null;
  predicted: number | null;
  published: number | null;
}

/** A change, and the time around it in which nothing else changed. */
export interface ChangeSpan {
  fromS: number;
  /** Null: nothing has changed yet. */
  atS: number | null;
  toS: number;
}

/** The stretch around the change at `atS`, between the changes before and after it. */
export function spanAround(
  atS: number | null,
  changes: readonly number[],
  endS: number,
): ChangeSpan {
  if (atS === null) return { fromS: 0, atS, toS: endS };
  return {
    fromS: Math.max(0, ...changes.filter((each) => each < atS)),
    atS,
    toS: Math.min(endS, ...changes.filter((each) => each > atS)),
  };
}

/** Run time [from, to); nothing when `from` is not before `to`. */
type Stretch = [fromS: number, toS: number];

/**
 * What is averaged to compare the rig before and after a change. Before: the last 5 s (at least 100
 * samples) before the change, but not before the estimator has settled after the start or the
 * change before it. After: from when its window holds no sample from before the change, up to the
 * next change or the end. The server's report has the same rule (server/api/run/before_after.h);
 * one list of cases tests both.
 */
export function stretchesAround(
  span: ChangeSpan,
  estimator: Pick<EstimatorShape, "window" | "integral">,
  period: number,
): { before: Stretch; after: Stretch } {
  const settles = settleS(estimator, period);
  const { atS, fromS, toS } = span;
  const beforeEnd = atS ?? toS;
  const lead = fromS === 0 ? START_S : period;
  const before = Math.max(
    fromS + settles + lead,
    beforeEnd - Math.max(BEFORE_S, BEFORE_SAMPLES * period),
  );
  return {
    before: [before, beforeEnd],
    after: [atS === null ? toS : atS + settles + period, toS],
  };
}

/** Mean estimates around a change, with the model's prediction and the published values. */
export function beforeAfter(
  slide: Slide,
  estimator: EstimatorShape,
  span: ChangeSpan,
  predicted: number[] | undefined,
  published: number[] | undefined,
): BeforeAfterRow[] {
  const { before, after } = stretchesAround(span, estimator, slide.period);
  const mean = (channel: number, [from, to]: Stretch) =>
    from < to ? (moments(slide, channel, from, to)?.mean ?? null) : null;
  return PARAMETERS[estimator.family].map((name, at) => ({
    name,
    before: mean(estimator.column + at, before),
    after: mean(estimator.column + at, after),
    predicted: predicted?.[at] ?? null,
    published: published?.[at] ?? null,
  }));
}
