import type { ChartColors } from "../charts/chart_port";
import type { Tokens } from "./tokens";

/** Colours and fonts of a chart in the current theme. */
export function chartLook(tokens: Tokens): {
  colors: ChartColors;
  fonts: { axis: string; label: string };
} {
  const family = getComputedStyle(document.documentElement).getPropertyValue("--font");
  return {
    colors: { ...tokens, text: tokens.muted },
    fonts: { axis: `12px ${family}`, label: `600 12px ${family}` },
  };
}
