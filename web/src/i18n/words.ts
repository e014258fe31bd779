import type { Schemas } from "../contract/types";
import type { Key } from "./catalogue";
import { i18n, t } from "./i18n.svelte";
import { formatQuantity } from "./quantity";

/**
 * The server's word for a state, a role or a kind, in the user's language; unchanged if unknown.
 */
export function word(
  group:
    | "state"
    | "rig"
    | "verdict"
    | "role"
    | "booking"
    | "session_end"
    | "source"
    | "scope"
    | "rubric"
    | "trial_state"
    | "trial_void"
    | "alarm"
    | "step"
    | "message"
    | "grade_sent"
    | "use"
    | "field"
    | "method_title"
    | "method_text",
  value: string,
): string {
  const key = `${group}_${value.toLowerCase().replace(/[:-]/g, "_")}`;
  return i18n.has(key) ? t(key as Key) : value;
}

/** A refusal of the server: a reason of its contract, with names and numbers as text. */
export interface Refused {
  message: string;
  reason?: string;
  parameters?: Record<string, string>;
}

/** What the server refuses and why; the server's English message if there is no sentence for it. */
export function refusalWords({ message, reason, parameters = {} }: Refused): string {
  // The contract's list of reasons: one without a sentence does not compile.
  const key: Key = `refused_${reason as Schemas["RefusalReason"]}`;
  if (reason && !i18n.has(key)) void i18n.loadAll();
  if (!i18n.has(key)) return message;
  const said = Object.entries(parameters).map(([name, value]) => [
    name,
    parameterWords(name, value, parameters.unit),
  ]);
  return t(key, Object.fromEntries(said));
}

/** Parameters that are names, also where they look like numbers. */
const NAMES = ["rig", "bench", "its", "asked", "now", "server", "component", "login", "profile"];

function parameterWords(name: string, value: string, unit?: string): string | number {
  if (name === "member") return word("field", value); // as the page's forms call it
  if (name === "words") return value.replaceAll("'", "");
  if (name === "state") return word("rig", value);
  if (name === "role") return word("role", value);
  if (name === "values" && unit) {
    return value
      .split(", ")
      .map((each) => formatQuantity(unit, Number(each)))
      .join(", ");
  }
  const moment = /^(\d{4}-\d\d-\d\d) (\d\d:\d\d) UTC$/.exec(value);
  if (moment) {
    const format = new Intl.DateTimeFormat(i18n.dates, { dateStyle: "short", timeStyle: "short" });
    return format.format(new Date(`${moment[1]}T${moment[2]}Z`));
  }
  const number = NAMES.includes(name) ? Number.NaN : Number(value);
  return value === "" || Number.isNaN(number) ? value : number;
}

/**
 * Where in what was sent the refused member is, if its own name does not say it: "Fault 2: ".
 * @param field  JSON pointer, or the name of a column
 */
export function placeWords(field: string | undefined): string {
  const at = /^\/faults\/(\d+)\//.exec(field ?? "")?.[1];
  return at === undefined ? "" : `${t("fault")} ${Number(at) + 1}: `;
}

/** What an attempt that failed says. */
export function wordsOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}
