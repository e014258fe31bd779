import { lab } from "../api/lab_client";
import type { Booking, LabEvent, RigClass, Session, Ticket } from "../api/lab_types";
import { t } from "../i18n/i18n.svelte";
import { newsWords } from "../i18n/words";
import { account } from "../shell/account.svelte";
import { announcer } from "../shell/announcer.svelte";
import { wordsOf } from "./attempts.svelte";
import { LabFeed, type LabState } from "./feed";

const TICK_MS = 1000;
const NEWS_MAX = 20;
const EVENTS_PER_PAGE = 100;
/** The lab warns five minutes, one minute and half a minute before the end of a session. */
export const ENDS_SOON_MS = 5 * 60_000;

/** The signed-in user's part of the lab: session, place in the queue, bookings, news. */
export class LabDesk {
  session = $state.raw<Session | null>(null);
  offeredToMe = $state.raw<Session | null>(null);
  tickets = $state.raw<Ticket[]>([]);
  bookings = $state.raw<Booking[]>([]);
  classes = $state.raw<RigClass[]>([]);
  news = $state.raw<LabEvent[]>([]);
  /** The last refusal; it is shown until the next action. */
  private refusal = $state("");
  private silent = $state(false);
  loaded = $state(false);
  now = $state(Date.now());
  private users = 0;
  private feed: LabFeed | null = null;
  private timer: ReturnType<typeof setInterval> | undefined;

  /** Classes of rigs that need a session; simulators do not. */
  get benches(): RigClass[] {
    return this.classes.filter((each) => !each.elastic);
  }

  get failure(): string {
    return this.refusal || (this.silent ? t("lab_silent") : "");
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
    return session?.state === "active" && Date.parse(session.hard_end) - this.now < ENDS_SOON_MS;
  }

  /** Listens while a component shows the desk; the returned function ends this. */
  open(): () => void {
    if (this.users++ === 0) {
      this.feed = new LabFeed({
        state: (state) => this.take(state),
        lost: () => {
          this.silent = true;
        },
      });
      void this.loadRest();
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
    try {
      await action();
      this.refusal = "";
      return true;
    } catch (error) {
      this.refusal = wordsOf(error);
      return false;
    }
  }

  private take(state: LabState): void {
    const offered = (session: Session) => session.offered_to === account.me.login;
    this.session = state.sessions.find((session) => !offered(session)) ?? null;
    this.offeredToMe = state.sessions.find(offered) ?? null;
    this.tickets = state.tickets.filter((each) => /waiting|offered/.test(each.state));
    this.bookings = state.bookings.filter((booking) => Date.parse(booking.end) > Date.now());
    this.news = [...state.news.toReversed(), ...this.news].slice(0, NEWS_MAX);
    for (const event of state.news) announcer.say(event.topic, newsWords(event));
    this.silent = false;
    this.loaded = true;
    void this.loadRest(false);
  }

  /** Loads the data that is not the user's own: the classes and, at first, earlier news. */
  private async loadRest(withNews = true): Promise<void> {
    try {
      this.classes = await lab.rigClasses();
      if (withNews) this.news = (await toldSoFar()).toReversed().slice(0, NEWS_MAX);
    } catch {
      this.silent = true;
    }
  }

  /** Clears everything: the next user of this page must not see the data of the previous one. */
  private forget(): void {
    this.session = null;
    this.offeredToMe = null;
    this.tickets = [];
    this.bookings = [];
    this.news = [];
    this.refusal = "";
    this.silent = false;
    this.loaded = false;
  }
}

/** News so far, oldest first, page by page. */
async function toldSoFar(): Promise<LabEvent[]> {
  let told: LabEvent[] = [];
  for (let since = 0; ; ) {
    const { items, next } = await lab.events(since);
    told = [...told, ...items].slice(-NEWS_MAX);
    if (items.length < EVENTS_PER_PAGE) return told;
    since = next;
  }
}

export const desk = new LabDesk();
