import type { Component, Fault } from "../contract/types";

/** The setting "one fault at a time", the same in every fault panel while the page is open. */
export const oneFault = $state({ on: true });

/** A fault that is, or will be, there beside another one. */
export interface OtherFault {
  components: Component[];
  /** The fault of the plan, or the armed one, that comes later; null: they are not nominal now. */
  coming: Pick<Fault, "component" | "value" | "at_s"> | null;
}

/**
 * What is in the way of a fault of `component`, if there may be one only: components that are not
 * nominal, then faults that are planned or armed for later. An intermittent one comes again until
 * its end.
 */
export function otherFault(
  component: Component,
  faulty: Component[],
  planned: Fault[],
  elapsedS: number,
): OtherFault | null {
  const components = faulty.filter((name) => name !== component);
  if (components.length > 0) return { components, coming: null };
  const coming = planned.find((fault) => {
    const lastS = fault.kind === "intermittent" ? (fault.until_s ?? fault.at_s) : fault.at_s;
    return fault.component !== component && (lastS ?? 0) > elapsedS;
  });
  return coming ? { components: [coming.component], coming } : null;
}
