import type { RunEvent } from "../contract/types";
import type { Slide } from "../stream/slide";
import { moments } from "./statistics";

const SIGMAS = 3;
const SAMPLES_MIN = 50;
/** What an estimator shows just after its window is full still swings. */
const CALM_S = 0.5;

/**
 * The stretch in which the healthy rig was learnt, in run time: that of the bench, or the newest that
 * was begun anew. What was switched or found later does not move it, so whoever may not know of a
 * fault sees the same as everybody else. Only a run that began with what another had learnt may have
 * a fault within it: there it ends at `onsetS`.
 */
export function learntStretch(
  healthy: { from_s: number; to_s: number },
  events: readonly RunEvent[],
  timeOf: (event: RunEvent) => number,
  onsetS: number | null,
): [number, number] {
  const again = events.findLast((event) => event.kind === "learning");
  if (again && typeof again.value === "number") return [timeOf(again), again.value];
  return [healthy.from_s, Math.min(healthy.to_s, onsetS ?? healthy.to_s)];
}

/** Three standard deviations around the mean of what an estimator says of that stretch. */
export function healthyBand(
  slide: Slide,
  channel: number,
  [fromS, toS]: [number, number],
  settlesS: number,
): [number, number] | null {
  const found = moments(slide, channel, fromS + settlesS + CALM_S, toS);
  if (!found || found.count < SAMPLES_MIN) return null;
  const reach = SIGMAS * found.deviation;
  return [found.mean - reach, found.mean + reach];
}
