import type { Change, Episode, Finding, Story } from "../../src/contract/types";
import { bench } from "./bench";

export const NOTHING: Story = { episodes: [], changes: [], change_times_s: [], set_back: false };

export const change = (component: string, value: number, at_s: number): Change => ({
  component,
  value,
  before: bench.nominal(component),
  at_s,
  nominal: bench.isNominal(component, value),
  others: [],
});

export function finding(component: string, at_s: number, more: Partial<Finding> = {}) {
  const measured = { value: 56, sigma: 1, unit: "ohm", bound: null, score: 1, margin: 0 };
  return {
    verdict: "fault" as const,
    detected_at_s: at_s,
    onset_s: at_s,
    ended_at_s: null,
    group: [component],
    candidates: [{ component, ...measured }],
    ...more,
  };
}

/** One alarm that was named at once. */
export const episode = (onset_s: number, more: Partial<Episode> = {}): Episode => ({
  onset_s,
  since_s: onset_s,
  ended_s: null,
  changes: [],
  detections: [
    {
      detected_at_s: onset_s,
      delay_s: null,
      isolated_at_s: onset_s + 0.26,
      named: [],
      of: "first",
    },
  ],
  finding: null,
  ...more,
});
