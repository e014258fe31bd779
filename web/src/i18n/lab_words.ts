import type { AuditEntry, LabEvent } from "../contract/types";
import type { Key } from "./catalogue";
import { fill, i18n, t } from "./i18n.svelte";
import { rigWords } from "./rig_words";
import { localTime, span } from "./times";
import { word } from "./words";

/** Verbs that say of themselves whom they concern. */
const OF_THEMSELVES = ["use_reset_link"];

/** Who did what, of a line of the audit log: "invited to the course Motors: ann". */
export function auditLine(entry: AuditEntry): {
  who: string;
  what: string;
  detail: string;
} {
  const { verb } = entry;
  const ofRun = entry.object.startsWith("run:");
  const [, owner] = (ofRun && /^of (?:user:)?([^\s;]+)/.exec(entry.detail)) || [];
  const login = owner ? "" : entry.object_login;
  const object = entry.object_name || login || objectWords(entry.object);
  const ofItself = OF_THEMSELVES.includes(verb) && entry.object_login;
  const who = ofItself || entry.actor_login || actorWords(entry.actor);
  const told = owner
    ? t("log_of", { owner: entry.object_login || owner })
    : detailWords(entry.detail);
  const key = `audit_${verb}`;
  const whole = i18n.has(key) ? i18n.text(key as Key) : "{verb} {object}";
  const what = fill(whole, { verb: verb.replaceAll("_", " "), object, detail: told });
  const said = whole.includes("{detail}") || told === object || told === who;
  return { who, what, detail: said ? "" : told };
}

/** The verb alone, as who searches for it types it. */
export function auditWords(verb: string): string {
  const key = `audit_${verb}`;
  return i18n.has(key) ? fill(i18n.text(key as Key), { object: "", detail: "" }) : verb;
}

/** Who did it, if it was nobody with an account. */
export function actorWords(actor: string): string {
  return actor === "system" ? t("log_system") : word("role", actor);
}

/** What was dealt with, if it has no name of its own: "rig:bench-1" is bench-1. */
export function objectWords(object: string): string {
  return object === "unknown login" ? t("log_unknown_login") : object.replace(/^[a-z_]+:/, "");
}

/** The detail of a line of the audit log, part by part; what people wrote stays as it is. */
export function detailWords(detail: string): string {
  const from = /^from (\S+?):?(?: (\w+))?$/.exec(detail);
  if (from) {
    const why = from[2] ? `: ${providerRefusal(from[2])}` : "";
    return t("log_from", { address: from[1] ?? "" }) + why;
  }
  if (detail === "ended API keys and calendar link") return t("log_keys_ended");
  const [, start, end, why] = OUTAGE.exec(detail) ?? [];
  if (start && end) return [span(start, end), ...(why ? [why] : [])].join(": ");
  const alarm = `alarm_${detail}`;
  if (i18n.has(alarm)) return t(alarm as Key);
  return memberTexts(detail)
    .map(memberWords)
    .join(", ")
    .replace(TIMES, (time) => localTime(time));
}

/** "START END reason" */
const OUTAGE = /^(\d{4}-\S+Z) (\d{4}-\S+Z) ?(.*)$/s;
const TIMES = /\b\d{4}-\d\d-\d\dT\d\d:\d\d(?::\d\d(?:\.\d+)?)?Z/g;

/** "role student; disabled; name" */
function memberTexts(detail: string): string[] {
  const parts = detail.split("; ");
  return parts.every((part) => /^(disabled$|enabled$|name$|role )/.test(part)) ? parts : [detail];
}

function memberWords(text: string): string {
  if (text === "disabled") return t("disabled");
  if (text === "enabled") return t("enabled");
  if (text === "name") return t("name");
  const [, name, value = ""] = /^(role|seen epoch) (.*)$/.exec(text) ?? [];
  if (name === "role") return `${t("role")}: ${word("role", value)}`;
  if (name === "seen epoch") return t("log_epoch", { epoch: Number(value) });
  return text;
}

/** Why a sign-in at a provider failed, by the word in the page's address. */
export function providerRefusal(reason: string | null): string {
  if (!reason) return "";
  const key = `failed_${reason}`;
  return i18n.has(key) ? t(key as Key) : t("failed_oidc_failed");
}

/** A message of the lab by its topic; the server's English text if there is no translation. */
export function newsWords(event: Pick<LabEvent, "topic" | "text"> & Partial<LabEvent>): string {
  const key = `news_${event.topic}`;
  if (!i18n.has(key)) return event.text;
  const parts = [
    t(key as Key, {
      text: event.text,
      rig: event.rig ?? t("news_the_rig"),
      who: event.who ?? t("news_somebody"),
    }),
  ];
  if (event.time) parts.push(timeWords(event.topic, event.time, event.at ?? ""));
  const reason = `news_for_${event.reason}`;
  const why = [
    ...(event.reason && i18n.has(reason) ? [t(reason as Key)] : []),
    // What versions before 22 of the database put before a person's words.
    ...(event.why ? [rigWords(event.why.replace(/^planned outage: /, ""))] : []),
  ].join(": ");
  if (why) parts.push(t("news_why", { why }));
  return parts.join(" ");
}

/** A session's end as what was left of it when this was said; of a booking its start. */
function timeWords(topic: string, time: string, at: string): string {
  if (topic !== "warning" && topic !== "shortened") {
    return t("news_booking_at", { time: localTime(time) });
  }
  const left_s = Math.max(0, Math.ceil((Date.parse(time) - Date.parse(at)) / 1000));
  return left_s < 120
    ? t("news_left_s", { seconds: left_s })
    : t("news_left_min", { minutes: Math.round(left_s / 60) });
}
