import type { Component } from "../contract/types";

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

const KEY = "faultlab.exercise";
const NOTHING: Progress = { run: "", answer: null };

/** Kept by this browser, so that the exercise can be left and taken up again. */
export const exerciseStore = {
  read(): Progress {
    try {
      return {
        ...NOTHING,
        ...(JSON.parse(localStorage.getItem(KEY) ?? "{}") as Partial<Progress>),
      };
    } catch {
      return NOTHING;
    }
  },
  write(progress: Progress): void {
    localStorage.setItem(KEY, JSON.stringify(progress));
  },
  clear(): void {
    localStorage.removeItem(KEY);
  },
};
