import { api, call } from "../api/client";
import type { Rig } from "../contract/types";
import { wordsOf } from "../i18n/words";
import type { Bench } from "../plant/bench";
import { benches } from "./benches.svelte";

export interface RigGroup {
  /** Undefined of rigs that have not said it. */
  bench: Bench | undefined;
  rigs: Rig[];
}

/** Of a state, as the colour of its dot says it. */
export function level(state: string): "good" | "busy" | "bad" {
  if (/offline|tripped|quarantined|maintenance/.test(state)) return "bad";
  return state === "idle" || state === "ready" ? "good" : "busy";
}

/** The rigs of this server, fetched once and again on demand. */
export class Rigs {
  list = $state.raw<Rig[]>([]);
  failure = $state("");
  loaded = $state(false);
  private last: Promise<void> | null = null;

  /** Neither the rigs nor a failure has come yet. */
  get awaited(): boolean {
    return !this.loaded && !this.failure;
  }

  load(): Promise<void> {
    this.last = this.fetchAll();
    return this.last;
  }

  /** Loads the rigs unless they are loaded or being loaded. */
  once(): Promise<void> {
    return this.last && !this.failure ? this.last : this.load();
  }

  private async fetchAll(): Promise<void> {
    try {
      const [list, { items }] = await Promise.all([
        api.rigs(),
        call("GET /rig-classes"),
        benches.load(),
      ]);
      const lab = new Map(items.flatMap((each) => each.members).map((rig) => [rig.id, rig]));
      this.list = list.map((rig) => {
        const known = lab.get(rig.id);
        return known ? { ...rig, lab: known.status, reason: known.reason } : rig;
      });
      this.failure = "";
      this.loaded = true;
    } catch (error) {
      this.failure = wordsOf(error);
    }
  }

  find(id: string | undefined): Rig | undefined {
    return this.list.find((rig) => rig.id === id);
  }

  /** A simulated rig of this bench that a plan without a rig may use, a free one before others. */
  simulated(bench: Bench | undefined): Rig | undefined {
    const all = this.list.filter((rig) => rig.kind === "simulated" && rig.bench === bench?.id);
    return all.find((rig) => rig.state === "idle" && !rig.in_use) ?? all[0];
  }

  /** By bench, in the order in which rigs name them. */
  get groups(): RigGroup[] {
    const groups = new Map<string | null, RigGroup>();
    for (const rig of this.list) {
      const group = groups.get(rig.bench);
      if (group) group.rigs.push(rig);
      else groups.set(rig.bench, { bench: benches.find(rig.bench), rigs: [rig] });
    }
    return [...groups.values()];
  }
}

export const rigs = new Rigs();
