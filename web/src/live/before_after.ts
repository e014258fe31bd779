import type { Component } from "../api/types";
import { continuousModel, discreteModel } from "../plant/model";
import { publishedFor } from "../plant/published";
import type { Slide } from "../stream/slide";
import type { EstimatorShape } from "./estimators";
import { PARAMETERS } from "./estimators";
import { moments } from "./statistics";

const BEFORE_S = 5;

export interface BeforeAfterRow {
  name: string;
  before: number | null;
  after: number | null;
  predicted: number | null;
  published: number | null;
}

/** The delay from the converter's edge to the sample that the nominal SWA parameters contain. */
export function delayOf(nominalSwa: number[] | undefined): number {
  const b0d = nominalSwa?.[0];
  if (b0d === undefined) return 0;
  const { b0, b1, a1 } = continuousModel();
  const ratio = (b0 - b0d) / (b0 - b1 / a1);
  const delay = ratio > 0 ? -a1 * Math.log(ratio) : 0;
  return delay < 1e-4 ? 0 : delay;
}

/**
 * Mean estimates over the healthy seconds before `onsetS` and over the time after the estimator has
 * settled, beside what Eq. 4 predicts for `fault` and what the paper printed for it.
 */
export function beforeAfter(
  slide: Slide,
  estimator: EstimatorShape,
  onsetS: number | null,
  endS: number,
  fault: { component: Component; value: number } | null,
  delayS: number,
): BeforeAfterRow[] {
  const healthyEnd = onsetS ?? endS;
  const healthyFrom = Math.max(estimator.settleS + 0.5, healthyEnd - BEFORE_S);
  const settled = onsetS === null ? null : onsetS + estimator.settleS + slide.period;
  const model = fault ? continuousModel({ [fault.component]: fault.value }) : null;
  const discrete = model ? discreteModel(model, slide.period, delayS) : null;
  const predicted = !model
    ? null
    : estimator.family === "sia"
      ? [model.b0, model.b1, model.a1]
      : discrete && [discrete.b0d, discrete.b1d, discrete.a1d];
  const published = fault ? publishedFor(fault.component, fault.value)?.[estimator.family] : null;
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
