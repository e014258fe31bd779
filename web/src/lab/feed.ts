import { ApiError, call } from "../api/client";
import type { Booking, LabEvent, Session, Ticket } from "../contract/types";
import { Link, socketAddress } from "../stream/link";

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

/** The lab's stream: queue place, offers and warnings arrive without polling. */
export function labFeed(events: LabFeedEvents): Link {
  const link: Link = new Link(
    {
      address: async () => socketAddress((await call("POST /events/stream-token")).code),
      isFatal: (error) => error instanceof ApiError && [403, 404].includes(error.status),
    },
    {
      phase: (phase) => {
        if (phase === "waiting") events.lost();
      },
      roundTrip: () => {},
      binary: () => {},
      refused: () => events.lost(),
      text: (message) => {
        link.ready();
        if (message.type === "lab") events.state(message as { type: string } & LabState);
      },
    },
  );
  void link.connect();
  return link;
}
