import type { Answer } from "../contract/types";
import { stored } from "../shell/stored";

/** What somebody has typed of an answer, kept in this browser until it is given. */
export interface AnswerDraft {
  /** "": not chosen yet; "healthy": no fault. */
  component: string;
  value?: number;
  /** One standard deviation, in the unit of the value. */
  valueError?: number;
  atS?: number;
  /** Percent. */
  confidence: number;
  text: string;
  /** [from, to] in run time, seconds. */
  evidence: [number, number][];
}

/** As many as the server takes. */
export const EVIDENCE_MAX = 8;

export const HEALTHY = "healthy";
const EMPTY: AnswerDraft = { component: "", confidence: 80, text: "", evidence: [] };
export const draftOf = (trial: number) => stored(`faultlab.trial.${trial}`, EMPTY);

/** As the server takes it; null while something is missing. @param unit SI, of the component */
export function answerOf(draft: AnswerDraft, unit: string): Answer | null {
  const { component, value, atS } = draft;
  const evidence = draft.evidence.map(([from_s, to_s]) => ({ from_s, to_s }));
  const rest = { confidence: draft.confidence / 100, text: draft.text, evidence };
  if (component === HEALTHY) return { component: null, ...rest };
  if (!component || value === undefined || !(value > 0)) return null;
  const at = atS === undefined || !Number.isFinite(atS) ? {} : { at_s: atS };
  const { valueError } = draft;
  const error = valueError === undefined || !(valueError >= 0) ? {} : { value_error: valueError };
  return { component, value, unit, ...error, ...at, ...rest };
}
