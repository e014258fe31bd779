import type { Slide } from "../stream/slide";
import type { EstimatorShape } from "./estimators";
import { PARAMETERS, settleS } from "./estimators";
import { moments } from "./statistics";

const BEFORE_S = 5;

export interface BeforeAfterRow {
  name: string;
  before: number | null;
  after: number | null;
  predicted: number | null;
  published: number | null;
}

/**
 * Mean estimates over the healthy seconds before `onsetS` and over the time after the estimator has
 * settled, beside what the model predicts for the fault and what was published about it.
 */
export function beforeAfter(
  slide: Slide,
  estimator: EstimatorShape,
  onsetS: number | null,
  endS: number,
  predicted: number[] | undefined,
  published: number[] | undefined,
): BeforeAfterRow[] {
  const settles = settleS(estimator, slide.period);
  const healthyEnd = onsetS ?? endS;
  const healthyFrom = Math.max(settles + 0.5, healthyEnd - BEFORE_S);
  const settled = onsetS === null ? null : onsetS + settles + slide.period;
  return PARAMETERS[estimator.family].map((name, at) => ({
    name,
    before: moments(slide, estimator.column + at, healthyFrom, healthyEnd)?.mean ?? null,
    after:
      settled === null || settled >= endS
        ? null
        : (moments(slide, estimator.column + at, settled, endS)?.mean ?? null),
    predicted: predicted?.[at] ?? null,
    published: published?.[at] ?? null,
  }));
}
