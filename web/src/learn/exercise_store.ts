import type { Component } from "../contract/types";
import { stored } from "../shell/stored";

export interface Answer {
  component: Component;
  value: number;
}

/** How far somebody is with the exercise: its run tells the rest. */
export interface Progress {
  /** Id; empty: not begun. */
  run: string;
  answer: Answer | null;
}

/** Kept by this browser, so that the exercise can be left and taken up again. */
export const exerciseStore = stored<Progress>("faultlab.exercise", { run: "", answer: null });
