import type { Candidate, Diagnosis } from "../api/types";
import { t } from "../i18n/i18n.svelte";
import type { RunModel } from "./run_model.svelte";

/** The components that the verdict names: one, or several that no sensor tells apart. */
export function namedBy(verdict: Diagnosis | null): Candidate[] {
  const candidates = verdict?.candidates ?? [];
  const group = (verdict?.group ?? [])
    .map((name) => candidates.find((each) => each.component === name))
    .filter((each): each is Candidate => each !== undefined);
  return group.length > 0 ? group : candidates.slice(0, 1);
}

/** "Fault: R1 ↑" */
export function verdictHeading(model: RunModel): string {
  const { verdict, bench } = model;
  switch (verdict?.verdict) {
    case "fault": {
      const named = namedBy(verdict);
      const arrow = ({ component, value }: Candidate) =>
        (value ?? 0) >= bench.nominal(component) ? "↑" : "↓";
      const names = named.map(({ component }) => component).join(` ${t("or")} `);
      return `${t("fault")}: ${names}${named.length === 1 && named[0] ? ` ${arrow(named[0])}` : ""}`;
    }
    case "unknown_fault":
      return t("verdict_unknown_fault");
    case "nominal":
      return t("verdict_nominal");
    case "not_excited":
      return t("verdict_not_excited");
    default:
      return model.running && !verdict?.settled ? t("verdict_calibrating") : t("verdict_none");
  }
}

/** "100.2 ± 0.1 Ω", or "> 5 mF" of a value that the record only bounds. */
export function sizeOf(model: RunModel, { component, value, sigma, bound }: Candidate): string {
  if (bound) return `${bound} ${model.bench.format(component, value)}`;
  return model.bench.formatWithSigma(component, value, sigma);
}
