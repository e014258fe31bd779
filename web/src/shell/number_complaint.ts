import { t } from "../i18n/i18n.svelte";
import { typedNumber } from "../i18n/numbers";

export interface NumberLimits {
  min?: number;
  max?: number;
  whole?: boolean;
  /** May be left empty. */
  optional?: boolean;
}

/** What is wrong with a number as it is typed; empty: nothing. */
export function numberComplaint(text: string, limits: NumberLimits): string {
  const { min = Number.NEGATIVE_INFINITY, max = Number.POSITIVE_INFINITY } = limits;
  if (text.trim() === "" && limits.optional) return "";
  const number = typedNumber(text);
  if (!Number.isFinite(number) || (limits.whole && !Number.isInteger(number)))
    return t("number_wanted");
  if (number >= min && number <= max) return "";
  const least = Number.isFinite(min) ? min : 0;
  return Number.isFinite(max)
    ? t("number_between", { least, most: max })
    : t("number_from", { least });
}
