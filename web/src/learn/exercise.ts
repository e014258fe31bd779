import type { Candidate, Change, Component } from "../contract/types";
import type { Bench } from "../plant/bench";
import { sameValue } from "../plant/bench";
import type { Answer } from "./exercise_store";

/** Where somebody is in the exercise; it follows from what has happened in the run. */
export type Step =
  | "start"
  | "learning"
  | "break"
  | "diagnosing"
  | "named"
  | "returning"
  | "hide"
  | "settling"
  | "answer"
  | "result"
  | "over";

/** The numbered stages that the steps belong to. */
export const STAGES: readonly (readonly Step[])[] = [
  ["start"],
  ["learning"],
  ["break"],
  ["diagnosing", "named"],
  ["returning", "hide"],
  ["settling", "answer"],
  ["result"],
];

/** "over" has no stage. */
export function stageOf(step: Step): number {
  return STAGES.findIndex((steps) => steps.includes(step)) + 1;
}

/** What is known of the run. */
export interface Seen {
  running: boolean;
  /** Whether the healthy rig is learnt; "refused": it cannot be. */
  learnt: "no" | "yes" | "refused";
  /** That the rig has confirmed, all of them. */
  changes: readonly Change[];
  /** Run time of the newest sample. */
  elapsedS: number;
  verdict: "nominal" | "named" | "other";
  /** Time that the shown estimator needs after a change. */
  settleS: number;
  answered: boolean;
}

/** The diagnosis may fail: after so long the exercise goes on without its answer. */
export const PATIENCE_S = 15;

/** The fault that is to be found: the first one after the one that was shown. */
export function hiddenFault(changes: readonly Change[]): Change | undefined {
  const back = changes.findIndex((each) => each.nominal);
  return back < 0 ? undefined : changes.slice(back).find((each) => !each.nominal);
}

export function stepOf(seen: Seen): Step {
  const { changes, elapsedS } = seen;
  const hidden = hiddenFault(changes);
  if (hidden) {
    if (seen.answered) return "result";
    if (elapsedS - hidden.at_s > seen.settleS) return "answer";
    return seen.running ? "settling" : "over";
  }
  if (!seen.running || seen.learnt === "refused") return "over";
  const shown = changes.find((each) => !each.nominal);
  if (!shown) return seen.learnt === "yes" ? "break" : "learning";
  const back = changes.find((each) => each.nominal);
  if (!back) {
    return seen.verdict === "named" || elapsedS - shown.at_s > PATIENCE_S ? "named" : "diagnosing";
  }
  return seen.verdict === "nominal" || elapsedS - back.at_s > PATIENCE_S ? "hide" : "returning";
}

/** Those that relays of the bench switch; of a bench without relays, those that its simulator does. */
export function partsOf(bench: Bench): Component[] {
  const switched = bench.symbols.filter((component) => !bench.simulated(component));
  return switched.length > 0 ? switched : bench.symbols;
}

/** Every part with each of its other values: what the hidden fault can be. */
export function faultsOf(bench: Bench): Answer[] {
  return partsOf(bench).flatMap((component) =>
    bench
      .values(component)
      .filter((value) => !bench.isNominal(component, value))
      .map((value) => ({ component, value })),
  );
}

/** The fault that is shown: the largest of the first part. */
export function firstFault(bench: Bench): Answer | undefined {
  const [component] = partsOf(bench);
  return faultsOf(bench).findLast((each) => each.component === component);
}

/** A fault at random, another one than was shown. @param chance  in [0, 1) */
export function drawFault(
  bench: Bench,
  shown: Answer | undefined,
  chance: number,
): Answer | undefined {
  const all = faultsOf(bench).filter((each) => !shown || !sameFault(each, shown));
  return all[Math.floor(chance * all.length)];
}

export function sameFault(a: Answer, b: Answer): boolean {
  return a.component === b.component && sameValue(a.value, b.value);
}

/** Values that differ by less are one: resistors of the common series have 5 %. */
const SAME_VALUE = 0.05;

/** What a value of another part must be to act as the truth does. */
export interface Equivalent {
  value: number;
  /** Whether the answer's value is that one, as well as it can be told. */
  given: boolean;
}

/**
 * The value of the answer's part that would act as the truth: what the diagnosis found for it, as
 * the server grades (server/course/grade.h). Null: none would.
 */
export function equivalentTo(
  answer: Answer,
  candidates: readonly Pick<Candidate, "component" | "value">[],
): Equivalent | null {
  const found = candidates.find((each) => each.component === answer.component)?.value;
  return found ? { value: found, given: Math.abs(answer.value / found - 1) <= SAME_VALUE } : null;
}

export type Grade = "exact" | "part" | "group" | "other_value" | "wrong";

/**
 * @param group  components that no measured signal tells apart, of the verdict
 * @param equivalent  to the truth, of the answer's component
 */
export function gradeOf(
  answer: Answer,
  truth: Answer,
  group: readonly Component[],
  equivalent: Equivalent | null,
): Grade {
  if (sameFault(answer, truth)) return "exact";
  if (answer.component === truth.component) return "part";
  const grouped = group.includes(answer.component) && group.includes(truth.component);
  if (!grouped || !equivalent) return "wrong";
  return equivalent.given ? "group" : "other_value";
}
