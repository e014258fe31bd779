import type { EstimatorName } from "../contract/types";

export type Family = "swa" | "sia";

export interface EstimatorShape {
  name: EstimatorName;
  family: Family;
  /** Index of the first of its three columns among the stream's channels. */
  column: number;
  window: number; // K
  integral: number; // m, 0 for SWA
}

export const ESTIMATORS: EstimatorShape[] = [
  { name: "swa_50", family: "swa", column: 5, window: 50, integral: 0 },
  { name: "swa_100", family: "swa", column: 8, window: 100, integral: 0 },
  { name: "swa_200", family: "swa", column: 11, window: 200, integral: 0 },
  { name: "sia_20_5", family: "sia", column: 14, window: 20, integral: 5 },
  { name: "sia_100_20", family: "sia", column: 17, window: 100, integral: 20 },
  { name: "sia_500_20", family: "sia", column: 20, window: 500, integral: 20 },
];

export const PARAMETERS: Record<Family, [string, string, string]> = {
  swa: ["b0d", "b1d", "a1d"],
  sia: ["b0", "b1", "a1"],
};

/** Seconds until the window contains no sample from before a change. */
export function settleS(
  estimator: Pick<EstimatorShape, "window" | "integral">,
  period: number,
): number {
  return (estimator.window + estimator.integral - 1) * period;
}

/** The samples that one estimate is made of, in run time. */
export function windowS(estimator: EstimatorShape, period: number): number {
  return (estimator.window + estimator.integral) * period;
}

/** The unit of a parameter of the model from uc to a channel of the unit `channel`. */
export function parameterUnit(parameter: string, channel: "V" | "A" | "rpm"): string {
  switch (parameter) {
    case "a1":
      return "s";
    case "b1":
      return channel === "V" ? "s" : `${channel}·s/V`;
    case "a1d":
      return `${channel}/${channel}`;
    default:
      return `${channel}/V`;
  }
}

export function ofFamily(family: Family): EstimatorShape[] {
  return ESTIMATORS.filter((estimator) => estimator.family === family);
}

export function windowLabel(estimator: EstimatorShape): string {
  return estimator.family === "swa"
    ? `K=${estimator.window}`
    : `(${estimator.window},${estimator.integral})`;
}

/** The one that tables and bands use: that of 100 samples if shown, else the first shown. */
export function primaryOf(family: Family, shown: Set<EstimatorName>): EstimatorShape {
  const all = ofFamily(family);
  const visible = all.filter((estimator) => shown.has(estimator.name));
  return (
    visible.find((estimator) => estimator.window === 100) ??
    visible[0] ??
    (all[1] as EstimatorShape)
  );
}
