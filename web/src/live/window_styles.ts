import type { Tokens } from "../theme/tokens";

export interface WindowStyle {
  color: string;
  dash?: number[];
}

/** Short, medium and long estimator windows differ in colour and in dash pattern. */
export function windowStyles(colors: Tokens): WindowStyle[] {
  return [
    { color: colors.short, dash: [2, 2] },
    { color: colors.medium },
    { color: colors.long, dash: [6, 3] },
  ];
}
