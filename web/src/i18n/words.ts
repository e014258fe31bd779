import type { Rig } from "../api/types";
import type { Key } from "./catalogue";
import { i18n, t } from "./i18n.svelte";

/**
 * The server's word for a state, a role or a kind, in the user's language; unchanged if unknown.
 */
export function word(
  group: "state" | "rig" | "verdict" | "role" | "booking",
  value: string,
): string {
  const key = `${group}_${value.toLowerCase()}`;
  return i18n.has(key) ? t(key as Key) : value;
}

/** What the server refuses and why; the server's English message if there is no translation. */
export function refusalWords(refusal: {
  message: string;
  reason?: string;
  parameters?: Record<string, string>;
}): string {
  const key = `refused_${refusal.reason}`;
  return i18n.has(key) ? t(key as Key, refusal.parameters) : refusal.message;
}

/** Why nobody can use a rig now; empty if there is nothing to say. */
export function rigTrouble(rig: Rig): string {
  const message = rig.health ?? "";
  if (rig.link?.refusal) {
    return refusalWords({ message, reason: rig.link.refusal, parameters: { rig: rig.id } });
  }
  return rig.reason || (rig.link?.state === "lost" ? message : "");
}

/**
 * Where in what was sent the refused member is, if its own name does not say it: "Fault 2: ".
 * @param field  JSON pointer, or the name of a column
 */
export function placeWords(field: string | undefined): string {
  const at = /^\/faults\/(\d+)\//.exec(field ?? "")?.[1];
  return at === undefined ? "" : `${t("fault")} ${Number(at) + 1}: `;
}

/** What somebody did, by the verb of the audit log: "changed a user". */
export function auditWords(verb: string): string {
  const key = `audit_${verb}`;
  return i18n.has(key) ? t(key as Key) : verb.replaceAll("_", " ");
}

/** The detail of a line of the audit log; the members of an object one by one. */
export function detailWords(detail: string): string {
  if (!detail.startsWith("{")) return detail;
  try {
    const members = Object.entries(JSON.parse(detail) as Record<string, unknown>);
    return members
      .map(([name, value]) => {
        const said = name === "role" && typeof value === "string" ? word("role", value) : value;
        return `${name.replaceAll("_", " ")}: ${typeof said === "object" ? JSON.stringify(said) : said}`;
      })
      .join(", ");
  } catch {
    return detail;
  }
}

/** Why the healthy rig was not learnt, by the check that failed; else the server's English text. */
export function learningWords(reason: string): string {
  const check = /check '([a-z_]+)' failed/.exec(reason)?.[1] ?? "";
  const key = `check_${check}`;
  return i18n.has(key) ? t(key as Key) : reason;
}

/** Why a sign-in at a provider failed, by the word in the page's address. */
export function providerRefusal(reason: string | null): string {
  if (!reason) return "";
  const key = `failed_${reason}`;
  return i18n.has(key) ? t(key as Key) : t("failed_oidc_failed");
}

/** A message of the lab by its topic; the server's English text if there is no translation. */
export function newsWords(event: { topic: string; text: string }): string {
  const key = `news_${event.topic}`;
  return i18n.has(key) ? t(key as Key, { text: event.text }) : event.text;
}
