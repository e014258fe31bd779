const RULES = {
  once: "",
  daily: "FREQ=DAILY",
  workdays: "FREQ=WEEKLY;BYDAY=MO,TU,WE,TH,FR",
  weekly: "FREQ=WEEKLY",
  fortnightly: "FREQ=WEEKLY;INTERVAL=2",
} as const;

/**
 * The first time and how it comes again, as the API takes them.
 * @param day    of the first one, "2027-01-04", in the zone of this computer
 * @param from   "10:00"
 * @param to     "12:00"; not after `from`: on the next day
 * @param until  the last day
 */
export function repeated(
  day: string,
  from: string,
  to: string,
  repeat: keyof typeof RULES,
  until: string,
): { start: string; end: string; repeat?: string } {
  const start = new Date(`${day}T${from}`);
  const end = new Date(`${day}T${to}`);
  if (end <= start) end.setDate(end.getDate() + 1);
  const times = { start: start.toISOString(), end: end.toISOString() };
  const rule = RULES[repeat];
  return rule ? { ...times, repeat: `${rule};UNTIL=${until.replaceAll("-", "")}` } : times;
}
