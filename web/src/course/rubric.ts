import type { Rubric } from "../contract/types";

/** A rubric as people write it: weights, percent, days. */
export interface RubricDraft
  extends Pick<Rubric, "detection" | "isolation" | "value" | "confidence"> {
  /** How near a value must be for all its points, percent. */
  within: number | undefined;
  /** In which a late answer is taken, and what each costs, percent. */
  lateDays: number | undefined;
  latePercent: number | undefined;
  /** Minutes from the begin of a trial to its answer; 0: until the exercise closes. */
  limitMin: number | undefined;
  /** Points off for a hint, percent; 0: there are none. */
  hintPercent: number | undefined;
  /** The last attempt counts, not the best. */
  lastCounts: boolean;
  /** While it is open, the lab takes no uploads of its students. */
  uploadsWait: boolean;
}

export const USUAL: Rubric = {
  detection: 20,
  isolation: 40,
  value: 30,
  confidence: 10,
  full_within: 0.05,
};

const HOURS = 24;
const USUAL_LATE_PERCENT = 20;
const percent = (share: number) => Number((100 * share).toPrecision(6));

export function rubricDraft(rubric: Rubric): RubricDraft {
  const whole = { ...USUAL, ...rubric };
  const { detection, isolation, value, confidence, late_h = 0 } = whole;
  return {
    detection,
    isolation,
    value,
    confidence,
    within: percent(whole.full_within ?? 0),
    lateDays: late_h / HOURS,
    limitMin: whole.time_limit_min ?? 0,
    hintPercent: whole.hint_percent ?? 0,
    lastCounts: whole.counts === "last",
    uploadsWait: whole.uploads_wait ?? false,
    latePercent: late_h ? (whole.late_percent_a_day ?? 0) : USUAL_LATE_PERCENT,
  };
}

export function rubricOf({
  within,
  lateDays,
  latePercent,
  limitMin,
  hintPercent,
  lastCounts,
  uploadsWait,
  ...weights
}: RubricDraft): Rubric {
  return {
    ...weights,
    full_within: (within ?? 0) / 100,
    late_h: HOURS * (lateDays ?? 0),
    late_percent_a_day: lateDays ? (latePercent ?? 0) : 0,
    time_limit_min: limitMin ?? 0,
    hint_percent: hintPercent ?? 0,
    counts: lastCounts ? "last" : "best",
    uploads_wait: uploadsWait,
  };
}
