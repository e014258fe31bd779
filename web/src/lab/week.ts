import type { Availability, Span } from "../contract/types";

export const SLOT_MINUTES = 30;
export const FIRST_HOUR = 7;
export const LAST_HOUR = 24;
const DAYS = 7;

export type SlotState = "free" | "short" | "taken" | "mine" | "outage" | "closed" | "past";

export interface Slot {
  start: Date;
  end: Date;
  state: SlotState;
  /** "bench-1: new brushes": planned outages in it, also where another rig is free. */
  outages: string;
  /** The courses whose time it is. */
  courses: string;
}

/** 00:00, local time, of the day of `moment`. */
export function dayStart(moment: Date): Date {
  return new Date(moment.getFullYear(), moment.getMonth(), moment.getDate());
}

/** Adds calendar days, not hours: a day of a clock change has 23 or 25 hours. */
export function addDays(day: Date, days: number): Date {
  return new Date(day.getFullYear(), day.getMonth(), day.getDate() + days);
}

export function weekSpan(start: Date): Span {
  return { start: start.toISOString(), end: addDays(start, DAYS).toISOString() };
}

export const NOTHING_KNOWN: Availability = {
  busy: [],
  next_free: [],
  slots: [],
  check_s: 0,
  refusal: null,
};

/** Is a booking of one's own, in the week from `start`, before FIRST_HOUR of a day? */
export function hasOwnAtNight(start: Date, availability: Availability): boolean {
  const mine = availability.busy.filter(({ kind }) => kind === "mine");
  return Array.from({ length: DAYS }, (_, day) => addDays(start, day)).some((date) => {
    const morning = new Date(date.getFullYear(), date.getMonth(), date.getDate(), FIRST_HOUR);
    return mine.some((span) => Date.parse(span.start) < +morning && +date < Date.parse(span.end));
  });
}

/**
 * Seven days from `start` as columns of slots between FIRST_HOUR, or midnight, and LAST_HOUR, local
 * time. A slot is `free` where a session that begins with it has a rig for all of its time.
 */
export function weekSlots(
  start: Date,
  availability: Availability,
  now: Date,
  night = false,
): Slot[][] {
  const busy: Busy[] = availability.busy.map((span) => ({
    kind: span.kind,
    what: [span.rig, span.reason ?? ""].filter(Boolean).join(": "),
    from: Date.parse(span.start),
    to: Date.parse(span.end),
  }));
  const free = new Map(availability.slots.map((slot) => [Date.parse(slot.start), slot.free]));
  return Array.from({ length: DAYS }, (_, day) => {
    const date = addDays(start, day);
    const slots: Slot[] = [];
    for (
      let minute = night ? 0 : FIRST_HOUR * 60;
      minute < LAST_HOUR * 60;
      minute += SLOT_MINUTES
    ) {
      const at = (minutes: number) =>
        new Date(date.getFullYear(), date.getMonth(), date.getDate(), 0, minutes);
      const [from, to] = [at(minute), at(minute + SLOT_MINUTES)];
      slots.push({
        start: from,
        end: to,
        state: stateOf(from, to, busy, free.get(from.getTime()), now),
        outages: whatOf("outage", hitsOf(from, to, busy)),
        courses: whatOf("course", hitsOf(from, to, busy)),
      });
    }
    return slots;
  });
}

interface Busy {
  kind: string;
  what: string;
  from: number;
  to: number;
}
const hitsOf = (from: Date, to: Date, busy: Busy[]) =>
  busy.filter((span) => span.from < to.getTime() && from.getTime() < span.to);

const whatOf = (kind: string, hits: Busy[]) =>
  hits
    .filter((span) => span.kind === kind)
    .map((span) => span.what)
    .join(", ");

function stateOf(
  from: Date,
  to: Date,
  busy: Busy[],
  free: number | undefined,
  now: Date,
): SlotState {
  if (from.getTime() < now.getTime()) return "past";
  const hits = hitsOf(from, to, busy);
  if (hits.some((span) => span.kind === "mine")) return "mine";
  if (hits.some(({ kind }) => kind === "closed" || kind === "course")) return "closed";
  if (free) return "free"; // one of several rigs is enough
  if (free === 0 && hits.length === 0) return "short"; // before something begins
  return hits.some((span) => span.kind === "outage") ? "outage" : "taken";
}
