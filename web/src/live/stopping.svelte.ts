import { ApiError, call, NoAnswer } from "../api/client";
import { wordsOf } from "../i18n/words";
import { connection } from "../loading/connection.svelte";
import type { RunModel } from "./run_model.svelte";

/** How long Stop waits for an answer. */
const ANSWER_MS = 2000;

/** Stop was pressed: it is sent until the server has it or the run is over. */
export class Stopping {
  /** It "waits" for the link, or is "sent". */
  state = $state<"" | "sent" | "waits">("");
  refused = $state("");

  constructor(private readonly run: RunModel) {}

  async press(): Promise<void> {
    if (this.state) return;
    this.refused = "";
    const { run } = this;
    this.state = run.link.phase !== "open" || run.stale ? "waits" : "sent";
    while (run.running && !(await this.send())) {
      this.state = "waits";
      await connection.again();
    }
    this.state = "";
  }

  /** False without an answer. */
  private async send(): Promise<boolean> {
    try {
      const signal = AbortSignal.timeout(ANSWER_MS); // stopping twice does no harm
      await call("POST /runs/{id}/stop", { id: this.run.id }, { signal });
    } catch (error) {
      if (error instanceof NoAnswer) return false;
      const over = error instanceof ApiError && error.status === 409; // it is over already
      if (!over && !this.run.faults.stop()) this.refused = wordsOf(error);
    }
    return true;
  }
}
