import { api } from "../api/client";
import type { Rig } from "../api/types";
import { Bench } from "../plant/bench";

/** The rigs of this server, fetched once and again on demand, and the benches that they are. */
export class Rigs {
  list = $state.raw<Rig[]>([]);
  benches = $state.raw<Bench[]>([]);
  failure = $state("");
  loaded = $state(false);
  private asked: Promise<void> | null = null;
  private last: Promise<void> | null = null;

  load(): Promise<void> {
    this.last = this.fetchAll();
    return this.last;
  }

  /** As they were fetched last, or are being fetched. */
  once(): Promise<void> {
    return this.last && !this.failure ? this.last : this.load();
  }

  /** What a page needs before it shows a value: the benches, and the rigs if they choose one. */
  async known(): Promise<void> {
    const rigsHere = this.once();
    await this.loadBenches();
    if (this.benches.length > 1) await rigsHere;
  }

  private async fetchAll(): Promise<void> {
    try {
      const [list, classes] = await Promise.all([api.rigs(), api.rigClasses(), this.loadBenches()]);
      const lab = new Map(classes.flatMap((each) => each.members).map((rig) => [rig.id, rig]));
      this.list = list.map((rig) => {
        const known = lab.get(rig.id);
        return known ? { ...rig, lab: known.status, reason: known.reason } : rig;
      });
      this.failure = "";
      this.loaded = true;
    } catch (error) {
      this.failure = error instanceof Error ? error.message : String(error);
    }
  }

  find(id: string | undefined): Rig | undefined {
    return this.list.find((rig) => rig.id === id);
  }

  /** The server's first bench is that of recordings and of rigs that are gone. */
  benchOf(rig: Rig | undefined): Bench | undefined {
    return this.benches.find((bench) => bench.about.id === rig?.bench) ?? this.benches[0];
  }

  /** Benches do not change while the page is open. */
  private loadBenches(): Promise<void> {
    this.asked ??= api.benches().then(
      (list) => {
        this.benches = list.map((about) => new Bench(about));
      },
      (error) => {
        this.asked = null;
        throw error;
      },
    );
    return this.asked;
  }
}

export const rigs = new Rigs();
