import type { Excitation, RunPlan } from "../contract/types";
import { t } from "../i18n/i18n.svelte";
import { significant } from "../i18n/numbers";
import type { Bench } from "./bench";
import { kindOf, levelsOf } from "./excitation";

/** "PRBS, J → 22·10⁻⁶ kg·m² @ 10 s"; without the value while the bench is not known. */
export function planWords(plan: RunPlan | undefined, bench: Bench | undefined): string {
  if (!plan) return "";
  if (plan.recording) return t("a_recording");
  const faults = (plan.faults ?? []).map(
    ({ component, value, at_s }) =>
      `${bench?.change(component, value) ?? component} @ ${significant(at_s ?? 0, 6)} s`,
  );
  return [drivenBy(plan), ...(faults.length > 0 ? faults : [t("no_fault")])].join(", ");
}

/** "Speed control", "PRBS" */
export function drivenBy(plan: RunPlan | undefined): string {
  return plan?.control ? t("speed_control") : kindWords(plan?.excitation ?? {});
}

/** "PRBS" */
export function kindWords(excitation: Excitation): string {
  const kind = kindOf(excitation);
  return kind === "prbs" ? "PRBS" : t(`excitation_${kind}`);
}

/** "PRBS, 2 V to 3 V" */
export function excitationWords(excitation: Excitation): string {
  const [low, high] = levelsOf(excitation);
  return t("excitation_is", { kind: kindWords(excitation), low, high });
}
