import { SvelteMap } from "svelte/reactivity";
import { call } from "../api/client";
import type { Schemas } from "../contract/types";
import { Bench } from "../plant/bench";

/**
 * The benches that this page has heard of. A description never changes, so each is fetched once:
 * those of this server with the list, any other (of an old run, say) by its id.
 */
export class Benches {
  /** This server's own; the first is the one meant where none is named. */
  list = $state.raw<Bench[]>([]);
  private readonly known = new SvelteMap<string, Bench>();
  private listed: Promise<void> | null = null;
  private readonly asked = new Map<string, Promise<Bench>>();
  private readonly wanted = new Set<string>();

  /** Asks again after a failure only. */
  load(): Promise<void> {
    this.listed ??= call("GET /benches").then(
      ({ items }) => {
        this.list = items.map((about) => this.take(about));
      },
      (error) => {
        this.listed = null;
        throw error;
      },
    );
    return this.listed;
  }

  /** The bench with this id; fails with the server's reason when it knows none. */
  async need(id: string): Promise<Bench> {
    await this.listed?.catch(() => {}); // it may be there
    const known = this.known.get(id);
    if (known) return known;
    let answer = this.asked.get(id);
    if (!answer) {
      answer = call("GET /benches/{bench}", { bench: id }).then((about) => this.take(about));
      answer.catch(() => this.asked.delete(id));
      this.asked.set(id, answer);
    }
    return answer;
  }

  /** Settles once each of these is here, or cannot be had. */
  async settle(ids: readonly string[]): Promise<void> {
    this.load().catch(() => {}); // mostly they are in the list
    await Promise.allSettled([...new Set(ids)].map((id) => this.need(id)));
  }

  /** The same for what is drawn: undefined until it is here, and when there is none. */
  find(id: string | null | undefined): Bench | undefined {
    if (!id) return undefined;
    const known = this.known.get(id);
    if (!known && !this.wanted.has(id)) {
      this.wanted.add(id);
      this.need(id).catch(() => {}); // what is drawn does without
    }
    return known;
  }

  /** Undefined until the list is here. */
  get first(): Bench | undefined {
    return this.list[0];
  }

  take(about: Schemas["Bench"]): Bench {
    const bench = this.known.get(about.id) ?? new Bench(about);
    this.known.set(about.id, bench);
    return bench;
  }
}

export const benches = new Benches();
