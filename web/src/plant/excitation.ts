import type { Excitation } from "../contract/types";

export type ExcitationKind = "prbs" | "step" | "multisine" | "chirp";

export function kindOf(excitation: Excitation): ExcitationKind {
  return excitation.kind === undefined || excitation.kind === "samples" ? "prbs" : excitation.kind;
}

/** Lowest and highest voltage. */
export function levelsOf(excitation: Excitation): [number, number] {
  if (excitation.kind === "multisine" || excitation.kind === "chirp") {
    const { offset_v = 0, amplitude_v = 0 } = excitation;
    return [offset_v - amplitude_v, offset_v + amplitude_v];
  }
  if (excitation.kind === "samples") return [0, 0];
  return [excitation.low_v ?? 0, excitation.high_v ?? 0];
}
