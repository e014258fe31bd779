import type { LabEvent } from "../contract/types";
import { account } from "../shell/account.svelte";

/** What takes something from a person, so that it is told until the person has seen it. */
const TOPICS = new Set([
  "taken_over",
  "handed_over",
  "idle_ended",
  "expired",
  "operator",
  "rig_failed",
  "booking_elsewhere",
  "shortened",
  "interrupted",
  "no_show",
  "offer_missed",
  "unfulfilled",
  "time_free",
  "time_not_free",
]);
const AGE_MAX_MS = 12 * 3_600_000;
const DISMISSED_MAX = 50;

export const isTold = (event: LabEvent) => TOPICS.has(event.topic);

/** Which news this person has dismissed, in this browser: in all its tabs, and after a reload. */
class Dismissed {
  private ids = $state.raw<number[]>([]);

  constructor() {
    globalThis.addEventListener?.("storage", ({ key }) => {
      if (key === this.key) this.read();
    });
  }

  private get key(): string {
    return `faultlab.told.${account.me.login ?? ""}`;
  }

  /** Of the person who is signed in now. */
  read(): void {
    const stored: unknown = JSON.parse(localStorage.getItem(this.key) ?? "[]");
    this.ids = Array.isArray(stored) ? stored : [];
  }

  add(id: number): void {
    this.ids = [...this.ids, id].slice(-DISMISSED_MAX);
    localStorage.setItem(this.key, JSON.stringify(this.ids));
  }

  /** The events that are still to be told, newest first as given. */
  rest(news: LabEvent[]): LabEvent[] {
    const from = Date.now() - AGE_MAX_MS;
    return news.filter(
      (event) => isTold(event) && Date.parse(event.at) > from && !this.ids.includes(event.id),
    );
  }
}

export const dismissed = new Dismissed();
