import { ApiError, NoAnswer } from "../api/client";
import { wordsOf } from "../i18n/words";
import { connection } from "../shell/connection.svelte";

interface Stoppable {
  send(): Promise<unknown>;
  /** When the request is refused; false when it cannot go that way either. */
  sendByStream(): boolean;
  /** Is the link gone, as far as the page can see? */
  cut(): boolean;
  running(): boolean;
}

/** Stop was pressed: it is sent until the server has it or the run is over. */
export class Stopping {
  /** It "waits" for the link, or is "sent". */
  state = $state<"" | "sent" | "waits">("");
  refused = $state("");

  constructor(private readonly run: Stoppable) {}

  async press(): Promise<void> {
    if (this.state) return;
    this.refused = "";
    this.state = this.run.cut() ? "waits" : "sent";
    while (this.run.running() && !(await this.send())) {
      this.state = "waits";
      await connection.again();
    }
    this.state = "";
  }

  /** False without an answer. */
  private async send(): Promise<boolean> {
    try {
      await this.run.send();
    } catch (error) {
      if (error instanceof NoAnswer) return false;
      const over = error instanceof ApiError && error.status === 409; // it is over already
      if (!over && !this.run.sendByStream()) this.refused = wordsOf(error);
    }
    return true;
  }
}
