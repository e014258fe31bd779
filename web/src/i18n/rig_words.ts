import type { Rig, RunEvent } from "../contract/types";
import type { Key } from "./catalogue";
import { i18n, t } from "./i18n.svelte";
import { refusalWords, word } from "./words";

/**
 * What rigs, their agents and the lab write into events, logs and reasons, as the page says it. The
 * text is stored and comes from machines of other versions, so it is known by its form; what is not
 * known here is shown as it is. `rest` is a text of the same kind, `trip_..` an interlock.
 */
const FORMS: [RegExp, Key][] = [
  [/^stopped by a person$/, "end_by_hand"],
  [/^stopped by another person$/, "end_by_another"],
  [/^the lease was revoked$/, "end_of_session"],
  [/^the server (?:stops|ends)$/, "end_of_server"],
  [/^the agent (?:ends|was asked to end)$/, "said_agent_ended"],
  [/^watchdog: no word from the (?:lease )?holder/, "said_watchdog"],
  [/^queue full: nobody reads the samples$/, "said_watchdog"],
  [/^a newer command came before this one could act$/, "said_newer_command"],
  [/^until the healthy rig is learnt, at (?<time>[\d.]+) s$/, "said_until_learnt"],
  [/^read from the rig after the server had ended without a word$/, "said_rest_read"],
  [/^the tick came late$/, "said_tick_late"],
  [/^live$/, "end_by_hand"],
  [/^not seen yet$/, "said_not_seen"],
  [/^being checked$/, "rig_cleaning"],
  [/^the rig does not answer$/, "said_no_answer"],
  [/^its server does not answer$/, "said_server_silent"],
  [/^it is another bench now$/, "said_other_bench_now"],
  [/^this server has no such rig now$/, "said_gone"],
  [/^the rig failed: (?<rest>.+)$/s, "said_failed_by"],
  [/^the rig was taken out: (?<rest>.+)$/s, "said_taken_out"],
  [/^the check between users did not end in time$/, "said_check_late"],
  [/^the check between users failed: (?<rest>.+)$/s, "said_check_failed"],
  [/^the check's record gives no estimate/, "said_check_no_estimate"],
  [/^the interlock (?<name>\w+) holds the rig/, "said_held_by_interlock"],
  [/^the relays do not answer$/, "said_relays_silent"],
  [/^the agent is not heard$/, "said_agent_silent"],
  [/^the agent is late$/, "said_agent_late"],
  [/^(?:b0d|gain) is (?<value>[\d.]+) of its norm$/, "said_gain_off"],
  [/^a1d is (?<value>-?[\d.]+), its norm (?<norm>-?[\d.]+)$/, "said_pole_off"],
  [/^too few samples after the alarm$/, "verdict_too_early"],
  [/^something has changed; what, is being worked out$/, "being_worked_out"],
  [/^something has changed just before the end/, "verdict_too_late"],
  [/^something may have changed a little/, "verdict_ends_too_soon"],
  [/^what follows the alarm fits the nominal rig$/, "verdict_fits_nominal"],
  [/^no single component(?:.+): beside (?<one>\w+) also (?<other>.+)$/, "verdict_beside"],
  [/^no single component explains the record$/, "verdict_no_single"],
  [/^the record is not of the calibrated rig(?:.+); (?<rest>it fits .+)$/, "verdict_not_this_rig"],
  [/^two components have changed together/, "verdict_two"],
  [/^the winding has moved by (?<percent>[-+\d.]+) %/, "verdict_warmed"],
  [/^(?<channel>\w+) reads (?<value>[\d.e+-]+) times what it should/, "verdict_sensor_gain"],
  [/^(?<channel>\w+) reads (?<value>[\d.e+-]+) (?<unit>\w+) too much/, "verdict_sensor_high"],
  [/^(?<channel>\w+) reads (?<value>[\d.e+-]+) (?<unit>\w+) too little/, "verdict_sensor_low"],
  [/^(?<channel>\w+) does not follow the motor/, "verdict_sensor_lost"],
  [
    /^dry friction takes (?<after>[\d.e+-]+) mNm, (?<before>[\d.e+-]+) before/,
    "verdict_friction_changed",
  ],
  [/^it fits without (?<channel>\w+):/, "suspect_without"],
  [/^its first (?<seconds>[\d.e+]+) s fit:/, "suspect_beginning"],
  [
    /^it fits when (?<channel>\w+) is multiplied by (?<factor>[\d.e+-]+): is its unit (?<unit>.+)\?$/,
    "suspect_unit",
  ],
  [
    /^it fits when (?<channel>\w+) is multiplied by (?<factor>[\d.e+-]+): is it read on the other side of the gear\?$/,
    "suspect_gear",
  ],
  [
    /^it fits when (?<channel>\w+) is multiplied by (?<factor>[\d.e+-]+): is it in rad\/s, on the other side of the gear\?$/,
    "suspect_gear_rad",
  ],
  [/^it fits when (?<channel>\w+) is multiplied by (?<factor>[\d.e+-]+)$/, "suspect_factor"],
  [/^it fits the bench (?<bench>[a-z\d-]+): was it measured there\?$/, "suspect_bench"],
  [/^the speed refutes the diagnosis$/, "compensation_refuted"],
  [/^withdrawn$/, "compensation_withdrawn"],
  [/^it fits with the other sign of (?<channel>\w+)$/, "suspect_sign"],
  [/^it fits when the readings are moved one row up/, "suspect_row_up"],
  [/^it fits when delta_s is below half a period/, "suspect_delta_below"],
  [/^it fits when delta_s is above half a period/, "suspect_delta_above"],
  [/^it fits when the readings are moved one row down$/, "suspect_row_down"],
  [
    /^step response: gain (?<gain>[\d.e+-]+) \+- (?<error>[\d.e+-]+) rpm\/V, time constant (?<time>[\d.e+-]+) \+- (?<time_error>[\d.e+-]+) ms$/,
    "step_response",
  ],
  [
    /^step response: it settles at (?<speed>[\d.e+-]+) \+- (?<error>[\d.e+-]+) rpm under (?<level>[\d.e+-]+) V, time constant (?<time>[\d.e+-]+) \+- (?<time_error>[\d.e+-]+) ms$/,
    "step_response_settles",
  ],
  [/^its account is gone or disabled$/, "job_no_account"],
  [/^its run ended as (?<state>\w+)$/, "job_run_ended"],
  [/^its run was stopped$/, "job_run_stopped"],
  [/^the server died three times on this job$/, "job_server_died"],
];

/** What was read and what was allowed: "motor current 5.2 A, allowed 4 A". */
const READ = /(?<value>[\d.]+) (?<unit>\w+), allowed (?<limit>[\d.]+) \w+$/;

/** @param name  of an interlock: hardware/README.md */
function tripWords(name: string, text: string): string {
  const key = `trip_${name}`;
  if (!i18n.has(key)) return text;
  const { value, unit, limit } = READ.exec(text)?.groups ?? {};
  const said = t(key as Key);
  return value === undefined
    ? said
    : `${said}: ${t("said_read", { value: Number(value), limit: Number(limit), unit: unit ?? "" })}`;
}

function said(name: string, value: string): string | number {
  if (name === "rest") return rigWords(value);
  if (name === "name") return tripWords(value, value);
  if (name === "state") return word("state", value);
  return Number.isNaN(Number(value)) ? value : Number(value);
}

export function rigWords(text: string): string {
  const check = /check '([a-z_]+)' failed/.exec(text)?.[1];
  if (check && i18n.has(`check_${check}`)) {
    const more = /; ((?:it fits|its first|step response:) .+)$/.exec(text)?.[1];
    return t(`check_${check}` as Key) + (more ? ` ${rigWords(more)}` : "");
  }
  const [, trip, what = ""] = /^(?:Interlock: )?([a-z_]+): (.*)$/s.exec(text) ?? [];
  if (trip && i18n.has(`trip_${trip}`)) return tripWords(trip, what);
  for (const [form, key] of FORMS) {
    const found = form.exec(text);
    if (!found) continue;
    if (!i18n.has(key)) void i18n.loadAll();
    if (!i18n.has(key)) return text;
    const values = Object.entries(found.groups ?? {}).map(([name, value]) => [
      name,
      said(name, value),
    ]);
    return t(key, Object.fromEntries(values));
  }
  return text;
}

/** What an event adds to its kind: by its reason, or in an old recording by its text. */
export function eventWords(event: RunEvent): string {
  const text = event.text ?? "";
  if (event.kind !== "refused" || !event.reason) return rigWords(text);
  return refusalWords({ message: text, reason: event.reason, parameters: event.parameters });
}

/** A simulated rig that is shared as a bench is. */
export function standsIn({ kind, profile }: Pick<Rig, "kind" | "profile">): boolean {
  return kind === "bench" && profile !== "";
}

/** "simulator", "real bench". */
export function kindWords(rig: Pick<Rig, "kind" | "profile">): string {
  return standsIn(rig) ? t("source_stand_in") : word("source", rig.kind);
}

/** Why nobody can use a rig now; empty if there is nothing to say. */
export function rigTrouble(rig: Rig): string {
  const message = rig.health ?? "";
  if (rig.link?.refusal) {
    return refusalWords({ message, reason: rig.link.refusal, parameters: { rig: rig.id } });
  }
  return rigWords(rig.reason || (rig.link?.state === "lost" ? message : ""));
}

/** The test that raised the alarm: "residual", "cusum", "glr_25". */
export function detectorWords(detector: string): string {
  const [, test = "", samples = ""] = /^([a-z]+)_?(\d*)$/.exec(detector) ?? [];
  const key = `detector_${test}`;
  return i18n.has(key) ? t(key as Key, { samples: Number(samples) }) : detector;
}
