import type { Component, RunEvent } from "../contract/types";
import { refusalWords } from "../i18n/words";
import { type Bench, sameValue } from "../plant/bench";

export type SettingState =
  | "nominal"
  | "planned"
  | "waiting"
  | "commanded"
  | "confirmed"
  | "refused";

/** The setting of one component: the value reported by the rig, and the requested value. */
export interface Setting {
  actual: number;
  asked: number | null;
  state: SettingState;
  reason: string;
  /** Run time of the confirmation or refusal. */
  atS: number | null;
}

export type Settings = Record<Component, Setting>;

/** Changes that wait in the server until the healthy rig is learnt. */
export type Waiting = Record<Component, number>;

export function settingAt(bench: Bench, component: Component, value: number): Setting {
  const state = bench.isNominal(component, value) ? "nominal" : "confirmed";
  return { actual: value, asked: null, state, reason: "", atS: null };
}

/** The known setting, otherwise the nominal one. */
export function settingOf(bench: Bench, settings: Settings, component: Component): Setting {
  return settings[component] ?? settingAt(bench, component, bench.nominal(component));
}

export function settingsFrom(
  bench: Bench,
  positions: Record<Component, { value: number }>,
): Settings {
  const settings: Settings = {};
  for (const [component, { value }] of Object.entries(positions))
    settings[component] = settingAt(bench, component, value);
  return settings;
}

/** The user requested `value`: shown hollow until the rig answers. */
export function asked(
  bench: Bench,
  settings: Settings,
  component: Component,
  value: number,
): Settings {
  const before = settingOf(bench, settings, component);
  return {
    ...settings,
    [component]: { ...before, asked: value, state: "commanded", reason: "" },
  };
}

export function refused(
  bench: Bench,
  settings: Settings,
  component: Component,
  reason: string,
): Settings {
  const before = settingOf(bench, settings, component);
  return { ...settings, [component]: { ...before, asked: null, state: "refused", reason } };
}

export function unrefused(bench: Bench, settings: Settings, component: Component): Settings {
  const before = settingOf(bench, settings, component);
  if (before.state !== "refused") return settings;
  return { ...settings, [component]: settingAt(bench, component, before.actual) };
}

/** The effect of a rig's event on the settings. Only the rig can make a setting "confirmed". */
export function applied(
  bench: Bench,
  settings: Settings,
  event: RunEvent,
  period: number,
): Settings {
  const { component, value } = event;
  if (event.kind === "trip") return settingsFrom(bench, {}); // every interlock leaves the relays nominal
  if (!component) return settings;
  if (event.kind === "refused") {
    const { text: message = "", reason, parameters } = event;
    return refused(bench, settings, component, refusalWords({ message, reason, parameters }));
  }
  if (event.kind === "change_waits" || event.kind === "change_dropped") {
    const before = settingOf(bench, settings, component);
    return { ...settings, [component]: settingAt(bench, component, before.actual) }; // not sent to the rig
  }
  if (value === undefined || value === null) return settings;
  if (event.kind === "fault_commanded") return asked(bench, settings, component, value);
  if (event.kind === "relay_confirmed") {
    const setting = settingAt(bench, component, value);
    setting.atS = event.t_s ?? event.index * period;
    return { ...settings, [component]: setting };
  }
  return settings;
}

/** The effect of an event on the waiting changes. */
export function waitingAfter(waiting: Waiting, event: RunEvent): Waiting {
  const { kind, component, value } = event;
  if (kind === "trip" || kind === "stopped" || kind === "finished") return {};
  if (!component || typeof value !== "number") return waiting;
  if (kind === "change_waits") return { ...waiting, [component]: value };
  const over =
    kind === "change_dropped" ||
    ((kind === "fault_commanded" || kind === "refused") && sameValue(waiting[component], value));
  if (!over) return waiting;
  const { [component]: _, ...others } = waiting;
  return others;
}

/** The settings shown by the sliders: a waiting change replaces the value of the rig. */
export function withWaiting(bench: Bench, settings: Settings, waiting: Waiting): Settings {
  const shown = { ...settings };
  for (const [component, value] of Object.entries(waiting)) {
    const before = settingOf(bench, settings, component);
    shown[component] = { ...before, asked: value, state: "waiting" };
  }
  return shown;
}

export function faultyComponents(bench: Bench, settings: Settings): Component[] {
  return Object.keys(settings).filter((component) => {
    const setting = settings[component] as Setting;
    return !bench.isNominal(component, setting.asked ?? setting.actual);
  });
}
