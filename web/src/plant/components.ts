import type { Component } from "../api/types";

export const RELAY_COMPONENTS: Component[] = ["R1", "R9", "R12", "C8"];
export const MOTOR_COMPONENTS: Component[] = ["Ra", "J", "B"];
export const COMPONENTS: Component[] = [...RELAY_COMPONENTS, ...MOTOR_COMPONENTS];

export const NOMINAL: Record<Component, number> = {
  R1: 1,
  R9: 10e3,
  R12: 10e3,
  C8: 47e-12,
  Ra: 7.41,
  J: 1.43e-6,
  B: 1.8e-6,
};

/** The server learns the healthy rig from the first seconds of a run. */
export const LEARNING_S = 5;

/** Values at the detents of a fault slider: relay positions (Table 2), and the motor's of the paper. */
export const DETENTS: Record<Component, number[]> = {
  R1: [1, 10, 56, 100],
  R9: [10e3, 33e3, 56e3, 100e3],
  R12: [10e3, 5.6e3, 3.3e3, 2e3],
  C8: [47e-12, 1e-6, 10e-6, 47e-6],
  Ra: [7.41, 0.741, 14.8, 74.1],
  J: [1.43e-6, 1.43e-8, 1.43e-5, 1.43e-4],
  B: [1.8e-6, 1.8e-8, 1.8e-5, 1.8e-4],
};

/** Relay that connects each value (Table 2). */
export const RELAYS: Partial<Record<Component, string[]>> = {
  R1: ["Do17", "Do16", "Do1", "Do0"],
  R9: ["Do19", "Do18", "Do3", "Do2"],
  R12: ["Do6", "Do7", "Do22", "Do23"],
  C8: ["Do21", "Do20", "Do5", "Do4"],
};

export function isMotor(component: Component): boolean {
  return MOTOR_COMPONENTS.includes(component);
}

/** Same setting, as far as float32 and JSON can say; no value is like none. */
export function sameValue(a: number | null | undefined, b: number): boolean {
  if (a === null || a === undefined) return false;
  return Math.abs(a - b) <= 1e-6 * Math.max(Math.abs(a), Math.abs(b));
}

export function nearestDetent(detents: number[], value: number): number {
  let best = 0;
  const distance = (at: number) => Math.abs(Math.log((detents[at] as number) / value));
  for (let at = 1; at < detents.length; at++) if (distance(at) < distance(best)) best = at;
  return best;
}
