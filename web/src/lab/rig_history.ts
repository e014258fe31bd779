import type { CheckStep, RigCheck, RigDay } from "../contract/types";
import { i18n, t } from "../i18n/i18n.svelte";
import { formatQuantity } from "../i18n/quantity";
import { word } from "../i18n/words";
import type { Bench } from "../plant/bench";

export const USES = ["people", "jobs", "checks", "idle", "out"] as const;
export type Use = (typeof USES)[number];

export const seconds = (day: RigDay, use: Use): number => day[`${use}_s`];

/** Hours of each use in the last `count` of the days. */
export function hoursOf(days: RigDay[], count: number): Record<Use, number> {
  const sum = { people: 0, jobs: 0, checks: 0, idle: 0, out: 0 };
  for (const day of days.slice(-count)) {
    for (const use of USES) sum[use] += seconds(day, use) / 3600;
  }
  return sum;
}

/** The end of today, local time, as the server reads it. */
export function nextMidnight(now: Date): string {
  return new Date(now.getFullYear(), now.getMonth(), now.getDate() + 1).toISOString();
}

/** "R1 = 10 Ω, Do16" of "R1 = 10, Do16"; as it is where the bench is not known. */
export function subjectText(subject: string, bench: Bench | undefined): string {
  const [, component, value, line] = /^(\w+) = (\S+), (Do\d+)$/.exec(subject) ?? [];
  if (!component) return subject;
  return `${positionText(component, Number(value), bench)}, ${line}`;
}

/** "R1 = 56 Ω". */
export function positionText(component: string, value: number, bench: Bench | undefined): string {
  const known = bench?.about.components.some((part) => part.symbol === component);
  return `${component} = ${bench && known ? bench.format(component, value) : value}`;
}

interface FigureText {
  measured: string;
  allowed: string;
  /** Of a contact: what the description expects. */
  expected: string;
}

/** A pure number keeps its digits; a quantity gets its unit. */
function number(value: number, unit: string): string {
  return unit === "V" || unit === "A"
    ? formatQuantity(unit, value, 3)
    : i18n.number(value, { minimumSignificantDigits: 4, maximumSignificantDigits: 4 });
}

export function figureText({ measured, low, high, unit }: CheckStep): FigureText {
  if (measured === null || low === null || high === null) {
    return { measured: "", allowed: "", expected: "" };
  }
  const tail = unit === "1/V" ? " 1/V" : "";
  const one = low === high;
  return {
    measured: number(measured, unit) + tail,
    allowed: one ? "" : `${number(low, unit)} … ${number(high, unit)}${tail}`,
    expected: one ? number(low, unit) : "",
  };
}

/** Why a check failed, from its first failed step; else what the server says. */
export function checkReason(check: RigCheck, bench?: Bench): string {
  const step = check.steps.find((each) => !each.passed);
  if (!step) return check.reason;
  const { measured, allowed } = figureText(step);
  const name = word("step", step.step);
  if (allowed) return t("step_outside", { step: name, measured, allowed });
  return `${name}${step.subject ? `, ${subjectText(step.subject, bench)}` : ""}: ${step.text || check.reason}`;
}
