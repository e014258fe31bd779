import type { Trial } from "../contract/types";

/** What the trials of a student, or of a group, came to. */
export interface ResultRow {
  /** Accounts. */
  members: number[];
  /** In the order in which they began. */
  trials: Trial[];
  best: number | null;
}

export function resultRows(trials: readonly Trial[]): ResultRow[] {
  const rows = new Map<string, ResultRow>();
  for (const trial of trials) {
    const key = trial.members.join(" ");
    const row = rows.get(key) ?? { members: trial.members, trials: [], best: null };
    rows.set(key, row);
    row.trials.push(trial);
    if (trial.points !== null) row.best = Math.max(row.best ?? 0, trial.points);
  }
  return [...rows.values()];
}
