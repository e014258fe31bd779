import type { Slide } from "../stream/slide";
import type { EstimatorShape } from "./estimators";
import { PARAMETERS, settleS } from "./estimators";
import { moments } from "./statistics";

const BEFORE_S = 5;
const BEFORE_SAMPLES = 100;

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

/**
 * Mean estimates over the seconds before a change and over the time after the estimator has
 * settled, up to the next change, together with the model's prediction and the published values.
 */
export function beforeAfter(
  slide: Slide,
  estimator: EstimatorShape,
  span: ChangeSpan,
  predicted: number[] | undefined,
  published: number[] | undefined,
): BeforeAfterRow[] {
  const settles = settleS(estimator, slide.period);
  const { atS, toS } = span;
  const beforeEnd = atS ?? toS;
  const lead = span.fromS === 0 ? 0.5 : slide.period;
  const beforeFrom = Math.max(
    span.fromS + settles + lead,
    beforeEnd - Math.max(BEFORE_S, BEFORE_SAMPLES * slide.period),
  );
  const settled = atS === null ? null : atS + settles + slide.period;
  const mean = (channel: number, from: number, to: number) =>
    from < to ? (moments(slide, channel, from, to)?.mean ?? null) : null;
  return PARAMETERS[estimator.family].map((name, at) => ({
    name,
    before: mean(estimator.column + at, beforeFrom, beforeEnd),
    after: settled === null ? null : mean(estimator.column + at, settled, toS),
    predicted: predicted?.[at] ?? null,
    published: published?.[at] ?? null,
  }));
}
