import type { Component, Finding, PathStep } from "../api/types";
import type { Bench } from "../plant/bench";

/** A step whose number is nearer to its limit than this factor could have gone the other way. */
const CLOSE = 2;

/** Why the path may end elsewhere than the verdict, by what the data show. */
export type Disagreement =
  | { why: "unknown" }
  | { why: "settling" }
  | { why: "close"; step: PathStep }
  | { why: "window" };

/** The components at the end of the paper's path. */
export function pathEnd(path: readonly PathStep[], bench: Bench): Component[] {
  const words = (path.at(-1)?.leads_to ?? "").split(/,\s*|\s+or\s+/);
  return words.filter((word) => bench.symbols.includes(word));
}

/** Null when the end of the path is in the verdict, or there is nothing to compare. */
export function disagreement(finding: Finding | null, bench: Bench): Disagreement | null {
  const path = finding?.path ?? [];
  if (!finding || path.length === 0) return null;
  const end = pathEnd(path, bench);
  if (finding.verdict === "unknown_fault") return end.length > 0 ? { why: "unknown" } : null;
  if (finding.verdict !== "fault") return null;
  const named = namedBy(finding, bench);
  if (named.length === 0 || end.some((name) => named.includes(name))) return null;
  if (finding.settled === false) return { why: "settling" };
  const step = path.find(isClose);
  return step ? { why: "close", step } : { why: "window" };
}

/**
 * The components of the verdict: those that no sensor tells apart, in the order of the bench,
 * otherwise the best one.
 */
export function namedBy(
  finding: Pick<Finding, "group" | "candidates">,
  bench: Bench | undefined,
): Component[] {
  const best = finding.candidates?.[0]?.component;
  if (!finding.group?.length) return best ? [best] : [];
  const place = (name: Component) => bench?.symbols.indexOf(name) ?? 0;
  return [...finding.group].sort((a, b) => place(a) - place(b));
}

function isClose(step: PathStep): boolean {
  const { value, threshold } = step;
  if (typeof value !== "number" || typeof threshold !== "number" || threshold === 0) return false;
  const times = Math.abs(value / threshold);
  return times > 1 / CLOSE && times < CLOSE;
}
