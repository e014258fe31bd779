import type { RunPlan } from "../api/types";
import { t } from "../i18n/i18n.svelte";
import { formatQuantity } from "../plant/quantity";

/** "PRBS, R1 → 100 Ω @ 10 s" */
export function planWords(plan: RunPlan | undefined): string {
  if (!plan) return "";
  if (plan.recording) return t("a_recording");
  const faults = (plan.faults ?? []).map(
    (fault) =>
      `${fault.component} → ${formatQuantity(fault.component, fault.value)} @ ${fault.at_s} s`,
  );
  const excitation = plan.excitation?.kind ?? "prbs";
  const name = excitation === "prbs" ? "PRBS" : excitation;
  return [name, ...(faults.length > 0 ? faults : [t("no_fault")])].join(", ");
}
