import type { Component as View } from "svelte";
import { late } from "../../i18n/i18n.svelte";
import type { Parts } from "./parts";

interface Circuit {
  /** Parameters of the structure that have a place in the drawing. */
  places: readonly string[];
  load: () => Promise<{ default: View<{ parts: Parts }> }>;
}

const MOTOR = ["Ra", "La", "Ke", "KT", "J", "B"];

const DRIVER: Circuit = {
  places: ["k", "Rs", ...MOTOR],
  load: () => late(() => import("./MotorDriver.svelte")),
};

/** One drawing for each structure of the server's `core/structures`, by its name. */
const CIRCUITS: Partial<Record<string, Circuit>> = {
  "inverting-amplifier": {
    places: ["R9", "R10", "R5", "C8", "R12", "R14", "R15", "R1", ...MOTOR],
    load: () => late(() => import("./InvertingAmplifier.svelte")),
  },
  "motor-driver": DRIVER,
  "motor-by-speed": DRIVER,
  "current-driver": DRIVER,
};

/** Of a structure that this page does not know: blocks without places. */
const BLOCKS: Circuit = { places: [], load: () => late(() => import("./BlockDiagram.svelte")) };

export function circuitOf(structure: string): Circuit {
  return CIRCUITS[structure] ?? BLOCKS;
}
