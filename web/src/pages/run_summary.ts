import type { Run } from "../contract/types";
import { t } from "../i18n/i18n.svelte";
import { significant } from "../i18n/numbers";
import { word } from "../i18n/words";
import { isRecorded } from "../live/recorded";
import { namedBy, verdictWords } from "../live/verdict_words";
import type { Bench } from "../plant/bench";
import { drivenBy, planWords } from "../plant/plan_words";

const TOLD_MAX = 3;

/** What happened: "PRBS, R12 → 5.6 kΩ @ 10 s"; of a run that goes on, what is planned too. */
export function happenedWords(run: Run, bench: Bench | undefined): string {
  const changes = run.story?.changes ?? [];
  if (run.state === "running" && changes.length === 0) return planWords(run.plan, bench);
  const shown =
    changes.length > TOLD_MAX ? [...changes.slice(0, 1), ...changes.slice(1 - TOLD_MAX)] : changes;
  const told = shown.map(
    ({ component, value, at_s }) =>
      `${bench?.change(component, value) ?? component} @ ${significant(Number(at_s.toFixed(2)), 6)} s`,
  );
  if (changes.length > TOLD_MAX) told.splice(1, 0, "…");
  const recorded = isRecorded(run);
  const first = recorded ? t("a_recording") : drivenBy(run.plan);
  const nothing = recorded ? [] : [nothingWords(run)];
  return [first, ...(told.length > 0 ? told : nothing)].join(", ");
}

/** Why there is no change: none was planned, it is not told yet, or the run ended before. */
function nothingWords({ plan, samples, period_s }: Run): string {
  if (plan?.sealed) return t("happened_sealed");
  const endedS = (samples ?? 0) * period_s;
  const came = (plan?.faults ?? []).some((fault) => (fault.at_s ?? 0) < endedS);
  if (came || !plan?.faults?.length) return t("no_fault");
  return t("happened_before", { time: significant(endedS, 4) });
}

/** What was found: "R1 ↑ 100 Ω; R9 or R12". */
export function foundWords(run: Run, bench: Bench | undefined): string {
  if (run.plan?.sealed && run.state !== "running") return t("verdict_sealed");
  if (!run.verdict) return "–";
  // a run without a calibration at its end does not get one later
  if (run.verdict === "calibrating" && run.state !== "running") return t("verdict_none");
  const found = (run.story?.episodes ?? []).flatMap(({ finding }) => finding ?? []);
  if (found.length === 0) return word("verdict", run.verdict);
  return found
    .map((finding) => {
      const [best] = finding.candidates;
      const alone = finding.verdict === "fault" && namedBy(finding, bench).length === 1 && best;
      const words = verdictWords(finding, bench);
      return alone && bench ? `${words} ${bench.format(best.component, best.value)}` : words;
    })
    .join("; ");
}
