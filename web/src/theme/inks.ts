/**
 * The colours of lines, those of Okabe and Ito, darkened where a line would not stand out from
 * white. The server's PNG has the light ones (server/plots/canvas.cc); a unit test compares them.
 */
export type Ink = "blue" | "vermilion" | "green" | "sky" | "purple" | "orange" | "black" | "grey";

export const lightInks: Record<Ink, string> = {
  blue: "#0072b2",
  vermilion: "#d55e00",
  green: "#009e73",
  sky: "#0a98d6",
  purple: "#aa4499",
  orange: "#b57a00",
  black: "#111111",
  grey: "#777777",
};

export const darkInks: Record<Ink, string> = {
  blue: "#63b3ff",
  vermilion: "#ff9a52",
  green: "#2fc796",
  sky: "#9adcff",
  purple: "#e08ad2",
  orange: "#f2b84b",
  black: "#e8eef4",
  grey: "#a3b1be",
};

/** The ink of each signal, and of the short, medium and long window of an estimator. */
export const INK_OF = {
  uc: "blue",
  um: "vermilion",
  ua: "green",
  ia: "purple",
  n: "sky",
  short: "green",
  medium: "blue",
  long: "purple",
} as const satisfies Record<string, Ink>;

export function tracesIn(inks: Record<Ink, string>): Record<keyof typeof INK_OF, string> {
  const colors = Object.entries(INK_OF).map(([name, ink]) => [name, inks[ink]]);
  return Object.fromEntries(colors);
}
