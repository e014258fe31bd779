import type { Availability, Span } from "../api/lab_types";

export const SLOT_MINUTES = 30;
export const FIRST_HOUR = 7;
export const LAST_HOUR = 22;
const DAYS = 7;

export type SlotState = "free" | "taken" | "mine" | "outage" | "past";

export interface Slot {
  start: Date;
  end: Date;
  state: SlotState;
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

export const NOTHING_KNOWN: Availability = { busy: [], next_free: [], slots: [] };

/** Seven days from `start` as columns of slots between FIRST_HOUR and LAST_HOUR, local time. */
export function weekSlots(start: Date, availability: Availability, now: Date): Slot[][] {
  const busy = availability.busy.map((span) => ({
    kind: span.kind,
    from: Date.parse(span.start),
    to: Date.parse(span.end),
  }));
  const free = new Map(availability.slots.map((slot) => [Date.parse(slot.start), slot.free]));
  return Array.from({ length: DAYS }, (_, day) => {
    const date = addDays(start, day);
    const slots: Slot[] = [];
    for (let minute = FIRST_HOUR * 60; minute < LAST_HOUR * 60; minute += SLOT_MINUTES) {
      const at = (minutes: number) =>
        new Date(date.getFullYear(), date.getMonth(), date.getDate(), 0, minutes);
      const [from, to] = [at(minute), at(minute + SLOT_MINUTES)];
      slots.push({
        start: from,
        end: to,
        state: stateOf(from, to, busy, free.get(from.getTime()) ?? 0, now),
      });
    }
    return slots;
  });
}

function stateOf(
  from: Date,
  to: Date,
  busy: { kind: string; from: number; to: number }[],
  free: number,
  now: Date,
): SlotState {
  if (from.getTime() < now.getTime()) return "past";
  const hits = busy.filter((span) => span.from < to.getTime() && from.getTime() < span.to);
  if (hits.some((span) => span.kind === "mine")) return "mine";
  if (free > 0) return "free"; // one of several rigs is enough
  return hits.some((span) => span.kind === "outage") ? "outage" : "taken";
}
