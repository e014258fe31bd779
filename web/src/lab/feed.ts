import { ApiError, send } from "../api/client";
import { lab } from "../api/lab_client";
import type { Booking, LabEvent, Session, Ticket } from "../contract/lab_types";
import { Link, socketAddress } from "../stream/link";

const ASK_EVERY_MS = 3000;

/**
 * The complete state for one user, sent by the lab after every change, so that a lost connection
 * needs no repair.
 */
export interface LabState {
  tickets: Ticket[];
  sessions: Session[];
  bookings: Booking[];
  /** News since the previous message; the page requests older ones. */
  news: LabEvent[];
  next: number;
}

export interface LabFeedEvents {
  state(state: LabState): void;
  lost(): void;
}

/**
 * The lab's stream: queue place, offers and warnings arrive without polling. If the server
 * refuses the stream (a proxy that does not support WebSockets), the same data is requested
 * every 3 s.
 */
export class LabFeed {
  private since = 0;
  private closed = false;
  private asking = false;
  private timer: ReturnType<typeof setInterval> | undefined;
  private readonly link: Link;

  constructor(private readonly events: LabFeedEvents) {
    this.link = new Link(
      {
        address: async () => {
          const { code } = await send<{ code: string }>("POST", "/events/stream-token", {});
          return socketAddress(code);
        },
        isFatal: (error) => error instanceof ApiError && [403, 404].includes(error.status),
      },
      {
        phase: (phase) => {
          if (phase === "waiting") events.lost();
        },
        roundTrip: () => {},
        binary: () => {},
        refused: () => {
          if (this.closed) return;
          this.timer = setInterval(() => void this.ask(), ASK_EVERY_MS);
          void this.ask();
        },
        text: (message) => {
          this.link.ready();
          if (message.type === "lab") this.take(message as { type: string } & LabState);
        },
      },
    );
    void this.link.connect();
  }

  close(): void {
    this.closed = true;
    this.link.close();
    clearInterval(this.timer);
  }

  private take(state: LabState): void {
    this.since = state.next;
    this.events.state(state);
  }

  private async ask(): Promise<void> {
    if (this.asking) return;
    this.asking = true;
    try {
      const [tickets, sessions, bookings, told] = await Promise.all([
        lab.tickets(),
        lab.sessions(),
        lab.bookings(),
        lab.events(this.since),
      ]);
      const news = this.since === 0 ? [] : told.items;
      if (!this.closed) this.take({ tickets, sessions, bookings, news, next: told.next });
    } catch {
      if (!this.closed) this.events.lost();
    } finally {
      this.asking = false;
    }
  }
}
