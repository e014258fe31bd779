import type { Finding } from "../api/types";
import { t } from "../i18n/i18n.svelte";
import { word } from "../i18n/words";
import type { Bench } from "../plant/bench";
import { namedBy } from "./paper_path";

/** "Fault: R1 ↑", "Fault: R12 or R9", "No fault". */
export function verdictWords(finding: Finding, bench: Bench | undefined): string {
  if (finding.verdict !== "fault") return word("verdict", finding.verdict);
  const named = namedBy(finding);
  if (named.length === 0) return t("fault");
  const best = finding.candidates[0];
  const alone = named.length === 1 && best && bench;
  const arrow = !alone ? "" : (best.value ?? 0) >= bench.nominal(best.component) ? " ↑" : " ↓";
  return `${t("fault")}: ${named.join(` ${t("or")} `)}${arrow}`;
}
