import { afterAll, beforeAll, describe, expect, it } from "vitest";
import { localTime, span, timeLeft } from "../src/i18n/times";
import {
  addDays,
  dayStart,
  hasOwnAtNight,
  NOTHING_KNOWN,
  weekSlots,
  weekSpan,
} from "../src/lab/week";

const zone = process.env.TZ;
const slotsPerDay = 34;

describe("week of slots", () => {
  beforeAll(() => {
    process.env.TZ = "Europe/Belgrade";
  });
  afterAll(() => {
    process.env.TZ = zone;
  });

  it("begins at midnight of the first day", () => {
    const start = new Date(2026, 10, 22, 0, 0);
    expect(dayStart(new Date(2026, 10, 22, 23, 59))).toEqual(start);
    expect(dayStart(start)).toEqual(start);
  });

  it("spans 167 and 169 hours in the weeks of a clock change", () => {
    const hours = (day: Date) => {
      const span = weekSpan(dayStart(day));
      return (Date.parse(span.end) - Date.parse(span.start)) / 3_600_000;
    };
    expect(hours(new Date(2026, 2, 29))).toBe(167);
    expect(hours(new Date(2026, 9, 25))).toBe(169);
    expect(hours(new Date(2026, 10, 16))).toBe(168);
  });

  it("shows the same local hours on the day of a clock change", () => {
    const days = weekSlots(dayStart(new Date(2026, 2, 29)), NOTHING_KNOWN, new Date(0));
    for (const day of days) {
      expect(day.length).toBe(slotsPerDay);
      expect(day[0]?.start.getHours()).toBe(7);
      expect(day.at(-1)?.end.getHours()).toBe(0);
    }
  });

  it("knows what is past, taken, out of order and one's own; intervals are half-open", () => {
    const monday = dayStart(new Date(2026, 10, 23));
    const at = (day: number, hour: number) =>
      new Date(addDays(monday, day).setHours(hour)).toISOString();
    const days = weekSlots(
      monday,
      {
        busy: [
          { kind: "booking", rig: "bench-1", start: at(1, 9), end: at(1, 10) },
          { kind: "booking", rig: "bench-2", start: at(1, 12), end: at(1, 13) },
          { kind: "outage", rig: "bench-1", reason: "brushes", start: at(2, 7), end: at(2, 22) },
          { kind: "mine", rig: "bench-1", start: at(3, 8), end: at(3, 9) },
        ],
        next_free: [],
        check_s: 30,
        refusal: null,
        slots: [
          { start: at(0, 11), free: 1 },
          { start: at(0, 12), free: 2 },
          { start: at(1, 8), free: 1 },
          { start: at(1, 9), free: 0 },
          { start: at(1, 10), free: 2 },
          { start: at(1, 12), free: 1 },
          { start: at(2, 15), free: 0 },
          { start: at(3, 8), free: 1 },
        ],
      },
      new Date(at(0, 12)),
    );
    const state = (day: number, hour: number) =>
      days[day]?.find((slot) => slot.start.getHours() === hour && slot.start.getMinutes() === 0)
        ?.state;
    expect(state(0, 11)).toBe("past");
    expect(state(0, 12)).toBe("free");
    expect(state(1, 8)).toBe("free");
    expect(state(1, 9)).toBe("taken");
    expect(state(1, 10)).toBe("free");
    expect(state(1, 12)).toBe("free"); // the class has another rig
    expect(state(2, 15)).toBe("outage");
    expect(state(3, 8)).toBe("mine");
  });

  it("names a planned outage also where another rig is free", () => {
    const monday = dayStart(new Date(2026, 10, 23));
    const start = new Date(new Date(monday).setHours(9)).toISOString();
    const end = new Date(new Date(monday).setHours(10)).toISOString();
    const [day] = weekSlots(
      monday,
      {
        busy: [{ kind: "outage", rig: "bench-1", reason: "brushes", start, end }],
        next_free: [],
        check_s: 30,
        refusal: null,
        slots: [{ start, free: 1 }],
      },
      new Date(0),
    );
    const slot = day?.find((each) => each.start.toISOString() === start);
    expect(slot?.state).toBe("free");
    expect(slot?.outages).toBe("bench-1: brushes");
    expect(day?.find((each) => each.start.toISOString() === end)?.outages).toBe("");
  });

  it("shows the night where it is asked for", () => {
    const monday = dayStart(new Date(2026, 10, 23));
    const days = weekSlots(monday, NOTHING_KNOWN, new Date(0), true);
    expect(days[0]?.length).toBe(48);
    expect(days[0]?.[0]?.start.getHours()).toBe(0);
  });

  it("knows that a booking of one's own is at night", () => {
    const monday = dayStart(new Date(2026, 10, 23));
    const busy = (kind: "mine" | "booking", day: number, from: number, to: number) => {
      const at = (hour: number) => new Date(addDays(monday, day).setHours(hour)).toISOString();
      return { ...NOTHING_KNOWN, busy: [{ kind, rig: "bench-1", start: at(from), end: at(to) }] };
    };
    expect(hasOwnAtNight(monday, busy("mine", 2, 3, 4))).toBe(true);
    expect(hasOwnAtNight(monday, busy("mine", 2, 6, 8))).toBe(true);
    expect(hasOwnAtNight(monday, busy("mine", 2, 7, 8))).toBe(false);
    expect(hasOwnAtNight(monday, busy("mine", 9, 3, 4))).toBe(false);
    expect(hasOwnAtNight(monday, busy("booking", 2, 3, 4))).toBe(false);
  });

  it("tells the two times of the hour apart that a clock change repeats", () => {
    const [first, second] = ["2026-10-25T00:30:00Z", "2026-10-25T01:30:00Z"];
    expect(localTime(first)).not.toBe(localTime(second));
    expect(localTime(first)).toMatch(/02:30 (CEST|GMT\+2)/);
    expect(localTime(second)).toMatch(/02:30 (CET|GMT\+1)/);
    expect(span(first, second)).toMatch(/02:30.*02:30/);
    expect(localTime("2026-10-25T03:30:00Z")).not.toMatch(/GMT|CET/);
    expect(localTime("2026-11-25T01:30:00Z")).not.toMatch(/GMT|CET/);
  });

  it("counts down to zero and no further", () => {
    const end = new Date(3_700_000).toISOString();
    expect(timeLeft(end, 0)).toBe("1:01:40");
    expect(timeLeft(end, 3_640_000)).toBe("1:00");
    expect(timeLeft(end, 9_000_000)).toBe("0:00");
  });
});
