import { api, type UploadSettings } from "../api/client";
import type { Run } from "../contract/types";

const OFFERED_MAX = 50;
/** Without a calibration there is no such verdict. */
const JUDGED = ["nominal", "fault", "unknown_fault"];

/** What a person says of how an upload is diagnosed. */
export class UploadSettingsModel {
  fromS = $state<number>();
  toS = $state<number>();
  calibration = $state("");
  #offered = $state.raw<Run[]>([]);

  get chosen(): Omit<UploadSettings, "name" | "bench"> {
    if (this.calibration) return { calibration: this.calibration };
    return { healthy_from_s: this.fromS, healthy_to_s: this.toS };
  }

  /** Uploads and runs whose calibration can be taken; without an answer there are none. */
  async offer(): Promise<void> {
    const lists = await Promise.all(
      (["upload", ""] as const).map((source) =>
        api.runs(undefined, OFFERED_MAX, { source }).catch(() => null),
      ),
    );
    this.#offered = lists
      .flatMap((page) => page?.items ?? [])
      .filter(({ state, verdict }) => state !== "running" && JUDGED.includes(verdict ?? ""));
  }
  offeredOn(bench: string | undefined): Run[] {
    return this.#offered.filter((run) => run.bench === bench);
  }
}
