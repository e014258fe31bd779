import { i18n } from "./i18n.svelte";

const MOMENT: Intl.DateTimeFormatOptions = {
  weekday: "short",
  day: "numeric",
  month: "short",
  hour: "2-digit",
  minute: "2-digit",
  hourCycle: "h23",
};
const asDate = (moment: string | Date) => (typeof moment === "string" ? new Date(moment) : moment);

const HOUR_MS = 3_600_000;
/** The clock shows this time twice: in the hour that is repeated when summer time ends. */
function isDoubled(date: Date): boolean {
  const shown = (of: Date) => [of.getDate(), of.getHours(), of.getMinutes()].join();
  return [-HOUR_MS, HOUR_MS].some((away) => shown(new Date(+date + away)) === shown(date));
}

/** So far away the day alone does not tell the year. */
const FAR_MS = 300 * 24 * HOUR_MS;

/**
 * "Mon 23 Nov, 14:30", in the language of the page and the user's own time zone; with the zone where
 * the clock shows a time twice, and with the year where it is far away.
 */
export function localTime(moment: string | Date): string {
  const date = asDate(moment);
  const zone = isDoubled(date) ? ({ timeZoneName: "short" } as const) : {};
  const year = Math.abs(+date - Date.now()) > FAR_MS ? ({ year: "numeric" } as const) : {};
  return date.toLocaleString(i18n.dates, { ...MOMENT, ...year, ...zone });
}

/** "Mon 23 Nov, 14:30 – 15:00": the day appears only once if both times are on it. */
export function span(start: string | Date, end: string | Date): string {
  const [from, to] = [asDate(start), asDate(end)];
  if (isDoubled(from) || isDoubled(to)) return `${localTime(from)} – ${localTime(to)}`;
  return new Intl.DateTimeFormat(i18n.dates, MOMENT).formatRange(from, to);
}

const two = (value: number) => String(value).padStart(2, "0");

/** "1:05:09" or "4:59" until `iso`; "0:00" after it. */
export function timeLeft(iso: string, nowMs: number): string {
  const seconds = Math.max(0, Math.round((Date.parse(iso) - nowMs) / 1000));
  const minutes = Math.floor(seconds / 60);
  if (minutes < 60) return `${minutes}:${two(seconds % 60)}`;
  return `${Math.floor(minutes / 60)}:${two(minutes % 60)}:${two(seconds % 60)}`;
}

/** As `<input type="datetime-local">` has it, in the user's own zone. */
export function localInput(time: Date): string {
  const day = `${time.getFullYear()}-${two(time.getMonth() + 1)}-${two(time.getDate())}`;
  return `${day}T${two(time.getHours())}:${two(time.getMinutes())}`;
}

/** The first instant of a day of `<input type="date">`, ISO 8601; empty for no day. */
export function dayStart(day: string, daysLater = 0): string {
  if (!day) return "";
  const [year, month, date] = day.split("-").map(Number) as [number, number, number];
  return new Date(year, month - 1, date + daysLater).toISOString();
}

/** The first instant after that day. */
export const dayEnd = (day: string) => dayStart(day, 1);
