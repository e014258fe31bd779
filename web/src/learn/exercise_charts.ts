import { ESTIMATORS, type EstimatorShape } from "../live/estimators";

/** The one estimator that the exercise shows: it settles soon and is calm enough to read. */
export const SHOWN = ESTIMATORS.find((each) => each.name === "sia_100_20") as EstimatorShape;
