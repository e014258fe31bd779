import { lab } from "../api/lab_client";
import type { FaultSet } from "../contract/lab_types";

/** The fault sets of the user's courses, the same in every part of the page. */
class FaultSets {
  list = $state.raw<FaultSet[]>([]);

  async load(): Promise<void> {
    this.list = await lab.faultSets();
  }
}

export const faultSets = new FaultSets();
