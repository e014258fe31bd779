import { get } from "../api/client";
import { beforeAfter, spanAround } from "../live/before_after";
import type { Bench } from "../plant/bench";
import { type Estimates, studyPath } from "./demonstrations.svelte";
import { SHOWN } from "./exercise_charts";
import type { ExerciseRun } from "./exercise_run.svelte";
import type { Answer } from "./exercise_store";

/** What the exercise's estimator finds: the mean of each parameter. */
export type Found = readonly (number | null)[];

/** In the run, after the change at `changedAtS`. */
export function foundInRun(run: ExerciseRun, changedAtS: number): Found {
  if (!run.slide) return [];
  const times = run.changes.map((each) => each.at_s);
  const span = spanAround(changedAtS, times, run.elapsed);
  return beforeAfter(run.slide, SHOWN, span, undefined, undefined).map((each) => each.after);
}

/** On a recording of this fault. */
export async function foundWith(bench: Bench, { component, value }: Answer): Promise<Found> {
  const settings = { method: SHOWN.family, window: SHOWN.window, integral: SHOWN.integral };
  const path = studyPath(bench, "/estimates", [[component, value]], settings);
  const { parameters } = await get<Estimates>(path);
  return parameters.map((each) => each.mean_after);
}
