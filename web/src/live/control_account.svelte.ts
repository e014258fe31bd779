import { call } from "../api/client";
import type { RunControl } from "../contract/types";

/** How a run under speed control kept its reference, as the server has it. */
export class ControlAccount {
  account = $state.raw<RunControl | null>(null);
  private asked = "";

  constructor(private readonly run: string) {}

  /** Again with each piece of `news`; at the end with the run beside it. */
  async load(ended: boolean, news: string): Promise<void> {
    const wanted = ended ? "all" : news;
    if (this.asked === wanted) return;
    this.asked = wanted;
    try {
      const without = ended ? "include" : "";
      const account = await call("GET /runs/{id}/control", { id: this.run, without });
      if (this.asked === wanted) this.account = account;
    } catch {
      this.asked = ""; // the charts do without
    }
  }
}
