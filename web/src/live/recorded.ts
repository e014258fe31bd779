import type { Run } from "../contract/types";

/** Is it a record that somebody brought, or the replay of one? Nobody can change anything in it. */
export const isRecorded = (run: Run): boolean =>
  run.source === "upload" || Boolean(run.plan?.recording);
