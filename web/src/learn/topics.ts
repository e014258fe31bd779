import type { Component } from "svelte";
import type { Key } from "../i18n/catalogue";
import { late } from "../i18n/i18n.svelte";
import type { Bench } from "../plant/bench";

export interface Topic {
  /** The last part of its address. */
  name: string;
  title: Key;
  lead: Key;
  load: () => Promise<{ default: Component<{ bench: Bench }> }>;
}

/** The pages on the theory, in the order in which they build on each other. */
export const TOPICS: readonly Topic[] = [
  {
    name: "swa",
    title: "lesson_swa",
    lead: "lesson_swa_lead",
    load: () => late(() => import("./SwaTopic.svelte")),
  },
  {
    name: "sia",
    title: "lesson_sia",
    lead: "lesson_sia_lead",
    load: () => late(() => import("./SiaTopic.svelte")),
  },
  {
    name: "windows",
    title: "lesson_windows",
    lead: "lesson_windows_lead",
    load: () => late(() => import("./WindowsTopic.svelte")),
  },
  {
    name: "ambiguity",
    title: "lesson_ambiguity",
    lead: "lesson_ambiguity_lead",
    load: () => late(() => import("./AmbiguityTopic.svelte")),
  },
  {
    name: "detection",
    title: "lesson_detection",
    lead: "lesson_detection_lead",
    load: () => late(() => import("./DetectionTopic.svelte")),
  },
  {
    name: "methods",
    title: "lesson_methods",
    lead: "lesson_methods_lead",
    load: () => late(() => import("./MethodsTopic.svelte")),
  },
];
