import { darkInks, lightInks, tracesIn } from "./inks";

/**
 * Every colour of the page, defined once: CSS gets them as custom properties, the charts read
 * them here, and a unit test checks their contrast (text >= 4.5:1, lines >= 3:1 on their
 * surface). Traces are drawn in the inks of `inks.ts`.
 */
export const light = {
  page: "#eef1f4",
  surface: "#ffffff",
  raised: "#f6f8fa",
  /** Behind controls that cannot be used now. */
  disabled: "#e9edf1",
  border: "#d3dae1",
  control: "#7b8794",
  text: "#14202b",
  muted: "#52606d",
  accent: "#005a8f",
  onAccent: "#ffffff",
  danger: "#a8071a",
  onDanger: "#ffffff",
  good: "#0a6b3d",
  warn: "#8a5300",
  fault: "#b3001b",
  detect: "#005a8f",
  grid: "#e6eaee",
  nominal: "#3a4652",
  band: "rgba(0, 114, 178, 0.13)",
  settle: "rgba(230, 159, 0, 0.17)",
  gap: "rgba(90, 100, 110, 0.25)",
  select: "rgba(20, 32, 43, 0.07)",
  ...tracesIn(lightInks),
};

export type Tokens = Record<keyof typeof light, string>;

export const dark: Tokens = {
  page: "#0d1319",
  surface: "#151d25",
  raised: "#1c2630",
  disabled: "#222c36",
  border: "#2c3945",
  control: "#7f8e9d",
  text: "#e8eef4",
  muted: "#a3b1be",
  accent: "#6cc0f5",
  onAccent: "#06202f",
  danger: "#ff8087",
  onDanger: "#2b0206",
  good: "#5bd697",
  warn: "#f2b84b",
  fault: "#ff7078",
  detect: "#7cc9f8",
  grid: "#23303b",
  nominal: "#c3ced8",
  band: "rgba(86, 180, 233, 0.16)",
  settle: "rgba(240, 190, 70, 0.15)",
  gap: "rgba(160, 175, 190, 0.22)",
  select: "rgba(232, 238, 244, 0.1)",
  ...tracesIn(darkInks),
};

/** WCAG relative luminance of "#rrggbb". */
function luminance(hex: string): number {
  const channel = (at: number) => {
    const c = Number.parseInt(hex.slice(at, at + 2), 16) / 255;
    return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
  };
  return 0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5);
}

export function contrast(a: string, b: string): number {
  const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y) as [number, number];
  return (high + 0.05) / (low + 0.05);
}
