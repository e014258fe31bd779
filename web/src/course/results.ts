import type { Rubric, Trial } from "../contract/types";

/** What the trials of a student, or of a group, came to. */
export interface ResultRow {
  /** Accounts. */
  members: number[];
  /** In the order in which they began. */
  trials: Trial[];
  /** The one that counts, as in the gradebook: answered, and the best or the last. */
  counts: Trial | null;
}

/** One row a student or a group, also of those who never began. */
export function resultRows(
  trials: readonly Trial[],
  students: readonly number[] = [],
  which: Rubric["counts"] = "best",
): ResultRow[] {
  const rows = new Map<string, ResultRow>();
  for (const trial of trials) {
    const key = trial.members.join(" ");
    const row = rows.get(key) ?? { members: trial.members, trials: [], counts: null };
    rows.set(key, row);
    row.trials.push(trial);
    if (trial.state !== "void" && countsMore(trial, row.counts, which)) row.counts = trial;
  }
  const begun = new Set(trials.flatMap((trial) => trial.members));
  const others = students.filter((id) => !begun.has(id));
  return [...rows.values(), ...others.map((id) => ({ members: [id], trials: [], counts: null }))];
}

function countsMore(next: Trial, now: Trial | null, which: Rubric["counts"]): boolean {
  if (!now) return true;
  const counts = (trial: Trial) => trial.state === "answered" || Boolean(trial.awarded);
  const answered = counts(next);
  if (answered !== counts(now)) return answered;
  return which === "last" || !answered || (next.points ?? -1) > (now.points ?? -1);
}
