import { api } from "../api/client";
import type { Change, RunEvent, Story } from "../contract/types";
import { RunModel } from "../live/run_model.svelte";
import { sealedFrom } from "../live/story";
import { hiddenFault } from "./exercise";

/** Events that would tell which part it is. */
const TELLING = new Set<RunEvent["kind"]>(["fault_commanded", "relay_confirmed", "isolated"]);

/**
 * The run of an exercise: until the answer is given, its story, markers and announcements do not
 * tell the hidden fault.
 */
export class ExerciseRun extends RunModel {
  /** Run time from which on nothing is told; null: all is told. */
  private sealedS = $state<number | null>(null);

  /** What the rig has confirmed, hidden or not. */
  get changes(): readonly Change[] {
    return this.whole.changes;
  }

  /** Nothing is told of what happens from now on. */
  seal(): void {
    this.sealedS = this.elapsed;
  }

  /** The page is left: the simulator is for others now. */
  leave(): void {
    if (this.running || this.phase === "loading") void api.abandonRun(this.id).catch(() => {});
    this.close();
  }

  reveal(): void {
    this.sealedS = Number.POSITIVE_INFINITY;
  }

  override get story(): Story {
    const { fromS } = this;
    return fromS === Number.POSITIVE_INFINITY ? this.whole : sealedFrom(this.whole, fromS);
  }

  protected override tells(event: RunEvent): boolean {
    return !TELLING.has(event.kind) || this.timeOf(event) < this.fromS;
  }

  /** A page that was opened again finds the hidden fault among the events. */
  private get fromS(): number {
    return this.sealedS ?? hiddenFault(this.changes)?.at_s ?? Number.POSITIVE_INFINITY;
  }
}
