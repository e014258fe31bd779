import type { FaultSet, SetFile } from "../contract/types";

/** Of one with a pool the faults are made from the pool. */
export function setFile({ name, bench, visible, faults, pool }: FaultSet): SetFile {
  return pool ? { name, bench, pool } : { name, bench, visible, faults };
}

/** Back from a file; null if it is none. What its faults are worth is the server's to say. */
export function readSet(text: string): SetFile | null {
  try {
    const { name, bench, visible, faults, pool } = JSON.parse(text);
    if (typeof name !== "string" || typeof bench !== "string") return null;
    if (pool && typeof pool === "object") return { name, bench, pool };
    return Array.isArray(faults) ? { name, bench, visible: visible === true, faults } : null;
  } catch {
    return null;
  }
}
