import { lab } from "../api/lab_client";
import type { Booking, LabEvent, RigClass, Session, Ticket } from "../api/lab_types";
import { announcer } from "../shell/announcer.svelte";

const EVERY_MS = 2000;

/** What the signed-in user holds in the lab: session, place in the queue, bookings, news. */
export class LabDesk {
  session = $state.raw<Session | null>(null);
  offeredToMe = $state.raw<Session | null>(null);
  tickets = $state.raw<Ticket[]>([]);
  bookings = $state.raw<Booking[]>([]);
  classes = $state.raw<RigClass[]>([]);
  news = $state.raw<LabEvent[]>([]);
  failure = $state("");
  loaded = $state(false);
  now = $state(Date.now());
  private since = 0;
  private timer: ReturnType<typeof setInterval> | undefined;

  constructor(private readonly login: () => string | undefined) {}

  start(): void {
    void this.load();
    this.timer = setInterval(() => void this.listen(), EVERY_MS);
  }

  stop(): void {
    clearInterval(this.timer);
  }

  async load(): Promise<void> {
    await this.attempt(async () => {
      const [sessions, tickets, bookings, classes] = await Promise.all([
        lab.sessions(),
        lab.tickets(),
        lab.bookings(),
        lab.rigClasses(),
      ]);
      const mine = (session: Session) => session.offered_to !== this.login();
      this.session = sessions.find(mine) ?? null;
      this.offeredToMe = sessions.find((session) => !mine(session)) ?? null;
      this.tickets = tickets.filter((each) => each.state === "waiting" || each.state === "offered");
      this.bookings = bookings.filter((booking) => Date.parse(booking.end) > Date.now());
      this.classes = classes;
      this.loaded = true;
    });
  }

  /** Does something and shows what came of it. */
  async act(action: () => Promise<unknown>): Promise<boolean> {
    const done = await this.attempt(action);
    if (done) await this.load();
    return done;
  }

  private async listen(): Promise<void> {
    this.now = Date.now();
    await this.attempt(async () => {
      const { items, next } = await lab.events(this.since);
      const first = this.since === 0;
      this.since = next;
      if (items.length === 0) return;
      this.news = [...items.reverse(), ...this.news].slice(0, 20);
      if (!first) for (const event of items) announcer.say(event.topic, event.text);
      await this.load();
    }, true);
  }

  private async attempt(action: () => Promise<unknown>, quiet = false): Promise<boolean> {
    try {
      await action();
      if (!quiet) this.failure = "";
      return true;
    } catch (error) {
      if (!quiet) this.failure = error instanceof Error ? error.message : String(error);
      return false;
    }
  }
}
