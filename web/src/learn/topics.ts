import { late } from "../i18n/i18n.svelte";

/** The pages on the theory, in the order in which they build on each other, by the last part of their address. */
export const TOPICS = [
  { name: "swa", load: () => late(() => import("./SwaTopic.svelte")) },
  { name: "sia", load: () => late(() => import("./SiaTopic.svelte")) },
  { name: "windows", load: () => late(() => import("./WindowsTopic.svelte")) },
  { name: "ambiguity", load: () => late(() => import("./AmbiguityTopic.svelte")) },
  { name: "detection", load: () => late(() => import("./DetectionTopic.svelte")) },
  { name: "methods", load: () => late(() => import("./MethodsTopic.svelte")) },
] as const;
