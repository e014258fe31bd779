import type { ChartColors } from "../charts/chart_port";
import type { Tokens } from "./tokens";

/** Colours and fonts of a chart in the current theme. */
export function chartLook(tokens: Tokens): {
  colors: ChartColors;
  fonts: { axis: string; label: string };
} {
  const family = getComputedStyle(document.documentElement).getPropertyValue("--font");
  return {
    colors: {
      text: tokens.muted,
      grid: tokens.grid,
      surface: tokens.surface,
      fault: tokens.fault,
      detect: tokens.detect,
      nominal: tokens.nominal,
      band: tokens.band,
      settle: tokens.settle,
      gap: tokens.gap,
      select: tokens.select,
    },
    fonts: { axis: `12px ${family}`, label: `600 12px ${family}` },
  };
}
