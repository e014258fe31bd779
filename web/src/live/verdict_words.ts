import type { Candidate, Component, Finding } from "../contract/types";
import { t } from "../i18n/i18n.svelte";
import { formatNumber } from "../i18n/quantity";
import { word } from "../i18n/words";
import type { Bench } from "../plant/bench";
import type { RunModel } from "./run_model.svelte";

/**
 * The components of the verdict: those that no sensor tells apart, in the order of the bench,
 * otherwise the best one.
 */
export function namedBy(
  finding: Pick<Finding, "group" | "candidates">,
  bench: Bench | undefined,
): Component[] {
  const best = finding.candidates?.[0]?.component;
  if (!finding.group?.length) return best ? [best] : [];
  const place = (name: Component) => bench?.symbols.indexOf(name) ?? 0;
  return [...finding.group].sort((a, b) => place(a) - place(b));
}

/** "Fault: R1 ↑", "Fault: R9 or R12", "No fault". */
export function verdictWords(finding: Finding, bench: Bench | undefined): string {
  const outside = outsideWords(finding);
  if (finding.verdict !== "fault") return outside ?? word("verdict", finding.verdict);
  const named = namedBy(finding, bench);
  if (named.length === 0) return t("fault");
  const best = finding.candidates[0];
  const alone = named.length === 1 && best && bench;
  const arrow = !alone ? "" : (best.value ?? 0) >= bench.nominal(best.component) ? " ↑" : " ↓";
  const beside = outside ? ` ${t("or")} ${outside.charAt(0).toLowerCase()}${outside.slice(1)}` : "";
  return `${t("fault")}: ${anyOf(named)}${arrow}${beside}`;
}

/** What is no component: of an unknown fault its cause, of a fault what is not excluded beside it. */
function outsideWords({ sensor, friction }: Finding): string | undefined {
  if (sensor) return t("verdict_sensor", { channel: sensor.channel });
  return friction ? t("verdict_friction") : undefined;
}

/** "R9 or R12" */
export function anyOf(named: readonly Component[]): string {
  return named.join(` ${t("or")} `);
}

/** The candidates that the verdict names: one, or several that no sensor tells apart. */
export function candidatesOf(
  verdict: Pick<Finding, "group" | "candidates"> | null,
  bench: Bench,
): Candidate[] {
  if (!verdict) return [];
  return namedBy(verdict, bench)
    .map((name) => verdict.candidates?.find((each) => each.component === name))
    .filter((each): each is Candidate => each !== undefined);
}

/** Of a run that is over, what it had before it was healthy again: "Fault: R9 or R12; set back". */
function setBack({ running, story, bench }: RunModel): string | null {
  if (running || !story.set_back) return null;
  const had = story.episodes.flatMap(({ finding }) => finding ?? []);
  if (had.length === 0) return null;
  return t("verdict_set_back", { had: had.map((each) => verdictWords(each, bench)).join("; ") });
}

/** What is known of the run now: "Fault: R1 ↑", "Learning the healthy rig". */
export function verdictHeading(model: RunModel): string {
  const { verdict, learning, running } = model;
  if (model.run?.plan?.sealed && !running) return t("verdict_sealed");
  if (learning || !verdict) return t(learning || running ? "verdict_calibrating" : "verdict_none");
  if (verdict.verdict !== "calibrating")
    return setBack(model) ?? verdictWords(verdict, model.bench);
  return t(running && !verdict.settled ? "verdict_calibrating" : "verdict_none");
}

/** That it is one of these: "97 %", "> 99.9 %"; of an older recording null. */
export function certaintyOf(named: readonly Candidate[]): string | null {
  const percent = named.reduce((sum, each) => sum + 100 * (each.probability ?? Number.NaN), 0);
  if (!Number.isFinite(percent)) return null;
  const most = 99.9;
  return `${percent > most ? "> " : ""}${formatNumber(Math.min(percent, most), percent > 99 ? 3 : 2)} %`;
}

/** "100.2 ± 0.1 Ω", or "> 5 mF" of a value that the record only bounds. */
export function sizeOf(model: RunModel, { component, value, sigma, bound }: Candidate): string {
  if (bound) return `${bound} ${model.bench.format(component, value)}`;
  return model.bench.formatWithSigma(component, value, sigma);
}
