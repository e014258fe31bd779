import type { Assignment } from "../contract/types";
import { t } from "../i18n/i18n.svelte";
import { fixed } from "../i18n/numbers";
import { localTime } from "../i18n/times";

/** ", late until Fri 14:00 for 25 % less a day"; empty where nothing is taken late. */
export function lateWords({ your_due, your_close, rubric }: Assignment): string {
  if (your_close === your_due) return "";
  const percent = fixed(rubric.late_percent_a_day ?? 0, 0);
  return t("assignment_late_until", { time: localTime(your_close), percent });
}
