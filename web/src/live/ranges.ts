/** Ranges of the estimate charts before anything is known; they grow when a fault leaves them. */
export const ESTIMATE_RANGES: Record<string, [number, number]> = {
  b0d: [0, 3],
  b1d: [-1.5, 0.5],
  a1d: [-1, 0],
  b0: [1, 3],
  b1: [0, 0.08],
  a1: [0, 0.1],
};
