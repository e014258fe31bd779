import { api } from "../api/client";
import type { RunControl } from "../api/types";

/** How a run under speed control kept its reference, as the server has it. */
export class ControlAccount {
  account = $state.raw<RunControl | null>(null);
  private asked = "";

  constructor(private readonly run: string) {}

  /** At the beginning the reference alone, at the end all there is. */
  async load(ended: boolean): Promise<void> {
    const wanted = ended ? "all" : "reference";
    if (this.asked === wanted) return;
    this.asked = wanted;
    try {
      const account = await api.control(this.run, ended);
      if (this.asked === wanted) this.account = account;
    } catch {
      this.asked = ""; // the charts do without
    }
  }
}
