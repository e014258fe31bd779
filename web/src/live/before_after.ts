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

/**
 * Mean estimates over the healthy seconds before `onsetS` and over the time after the estimator
 * has settled, together with the model's prediction for the fault and the published values.
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
  const healthyFrom = Math.max(
    settles + 0.5,
    healthyEnd - Math.max(BEFORE_S, BEFORE_SAMPLES * slide.period),
  );
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
