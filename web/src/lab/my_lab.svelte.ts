import { call } from "../api/client";
import type { Booking, LabEvent, RigClass, Session, Ticket } from "../contract/types";
import { t } from "../i18n/i18n.svelte";
import { newsWords } from "../i18n/lab_words";
import { connection } from "../loading/connection.svelte";
import { account } from "../shell/account.svelte";
import { announcer } from "../shell/announcer.svelte";
import type { Link } from "../stream/link";
import { Attempts } from "./attempts.svelte";
import { type LabState, labFeed } from "./feed";
import { dismissed, isTold } from "./told.svelte";

const TICK_MS = 1000;
const NEWS_MAX = 20;
const EVENTS_PER_PAGE = 100;
/** The lab warns five minutes, one minute and half a minute before the end of a session. */
export const ENDS_SOON_MS = 5 * 60_000;

/** The signed-in user's part of the lab: session, place in the queue, bookings, news. */
export class MyLab {
  session = $state.raw<Session | null>(null);
  offeredToMe = $state.raw<Session | null>(null);
  tickets = $state.raw<Ticket[]>([]);
  bookings = $state.raw<Booking[]>([]);
  classes = $state.raw<RigClass[]>([]);
  /** Newest first. */
  news = $state.raw<LabEvent[]>([]);
  /** What was taken from this person and has not been dismissed, newest first. */
  readonly told = $derived(dismissed.rest(this.news));
  /** The newest event that this page knows. */
  private newest = 0;
  /** The last refusal; it is shown until the next action. */
  private attempts = $state.raw(new Attempts());
  private silent = $state(false);
  loaded = $state(false);
  now = $state(Date.now());
  private users = 0;
  private feed: Link | null = null;
  private timer: ReturnType<typeof setInterval> | undefined;

  /** Classes of rigs that need a session; simulators do not. */
  get benches(): RigClass[] {
    return this.classes.filter((each) => !each.elastic);
  }

  /** A server that is away is told of once, by the whole page (shell/ConnectionNotice). */
  get failure(): string {
    return this.attempts.failure || (this.silent && !connection.away ? t("lab_silent") : "");
  }

  get offer(): Ticket | undefined {
    return this.tickets.find((ticket) => ticket.state === "offered");
  }

  /** The rig that is reserved until the offered ticket is accepted. */
  get held(): Session | null {
    return this.offer && this.session?.state === "held" ? this.session : null;
  }

  get endsSoon(): boolean {
    const { session } = this;
    return session?.state === "active" && Date.parse(session.end) - this.now < ENDS_SOON_MS;
  }

  /** Listens while a component shows it; the returned function ends this. */
  open(): () => void {
    if (this.users++ === 0) {
      dismissed.read();
      this.feed = labFeed({
        state: (state) => this.take(state),
        lost: () => {
          this.silent = true;
        },
      });
      void this.loadOthers(true);
      this.timer = setInterval(() => {
        this.now = Date.now();
      }, TICK_MS);
    }
    return () => {
      if (--this.users > 0) return;
      this.feed?.close();
      clearInterval(this.timer);
      this.forget();
    };
  }

  /** Runs an action and shows a refusal. Its effects arrive over the feed. */
  async act(action: () => Promise<unknown>): Promise<boolean> {
    return this.attempts.run(action);
  }

  private take(state: LabState): void {
    const offered = (session: Session) => session.offered_to === account.me.login;
    this.session = state.sessions.find((session) => !offered(session)) ?? null;
    this.offeredToMe = state.sessions.find(offered) ?? null;
    this.tickets = state.tickets.filter((each) => /waiting|offered/.test(each.state));
    this.bookings = state.bookings.filter((booking) => Date.parse(booking.end) > Date.now());
    for (const event of state.news) {
      if (!isTold(event)) announcer.say(event.topic, newsWords(event));
    }
    // what happened while the link was cut is not in the feed
    const missed = state.next > Math.max(this.newest, state.news.at(-1)?.id ?? 0);
    this.hear(state.news);
    this.silent = false;
    this.loaded = true;
    void this.loadOthers(missed);
  }

  /** Loads the data that is not the user's own: the classes and, where asked, the news so far. */
  private async loadOthers(withNews: boolean): Promise<void> {
    try {
      this.classes = (await call("GET /rig-classes")).items;
      if (withNews) this.hear(await toldSince(this.newest));
    } catch {
      this.silent = true;
    }
  }

  /** @param events  oldest first; known ones are left out */
  private hear(events: LabEvent[]): void {
    const known = new Set(this.news.map((event) => event.id));
    const fresh = events.filter((event) => !known.has(event.id));
    this.news = [...this.news, ...fresh].sort((a, b) => b.id - a.id).slice(0, NEWS_MAX);
    this.newest = this.news[0]?.id ?? 0;
  }

  /** Clears everything: the next user of this page must not see the data of the previous one. */
  private forget(): void {
    this.session = null;
    this.offeredToMe = null;
    this.tickets = [];
    this.bookings = [];
    this.news = [];
    this.newest = 0;
    this.attempts = new Attempts();
    this.silent = false;
    this.loaded = false;
  }
}

/** News after `since`, oldest first, page by page. */
async function toldSince(since: number): Promise<LabEvent[]> {
  let told: LabEvent[] = [];
  for (;;) {
    const { items, next } = await call("GET /events", { since, limit: EVENTS_PER_PAGE });
    told = [...told, ...items].slice(-NEWS_MAX);
    if (items.length < EVENTS_PER_PAGE) return told;
    since = next;
  }
}

export const myLab = new MyLab();
