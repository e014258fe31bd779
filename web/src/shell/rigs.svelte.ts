import { api } from "../api/client";
import type { Rig } from "../api/types";
import { Bench } from "../plant/bench";

/** The rigs of this server, fetched once and again on demand, and the benches that they are. */
class Rigs {
  list = $state.raw<Rig[]>([]);
  benches = $state.raw<Bench[]>([]);
  failure = $state("");
  loaded = $state(false);
  private asked: Promise<void> | null = null;

  async load(): Promise<void> {
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

  /** What a page needs before it shows a value: benches, and rigs as far as the server gives them. */
  async known(): Promise<void> {
    await Promise.all([this.loadBenches(), this.loaded ? undefined : this.load()]);
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
