/**
 * The server's description of a drawing (server/plots/figure.h): its content, not its
 * appearance.
 */
export interface FigureAxis {
  label: string;
  unit: string;
  range: [number, number] | null;
}
export interface FigureSeries {
  name: string;
  ink: string;
  dash: "solid" | "dashed" | "dotted";
  stair: boolean;
  x: (number | null)[];
  y: (number | null)[];
}
export interface FigureBand {
  x_from: number | null;
  x_to: number | null;
}
export interface FigurePanel {
  title: string;
  y: FigureAxis;
  series: FigureSeries[];
  levels: { y: number | null }[];
  bands: FigureBand[];
}
export interface FigureMark {
  kind: "fault" | "detected" | "returned";
  x: number;
  label: string;
}
export interface Figure {
  title: string;
  subtitle: string;
  x: FigureAxis;
  panels: FigurePanel[];
  marks: FigureMark[];
  footer: string;
}

export interface Aligned {
  x: Float64Array;
  y: Float32Array[];
}

/**
 * Puts series with x values of their own on one common, ascending x; NaN where a series has no
 * point.
 */
export function align(series: { x: (number | null)[]; y: (number | null)[] }[]): Aligned {
  const all = new Set<number>();
  for (const { x } of series) for (const at of x) if (at !== null) all.add(at);
  const x = Float64Array.from(all).sort();
  const slot = new Map<number, number>();
  x.forEach((at, index) => {
    slot.set(at, index);
  });
  const y = series.map((one) => {
    const column = new Float32Array(x.length).fill(Number.NaN);
    one.x.forEach((at, index) => {
      const value = one.y[index];
      const where = at === null ? undefined : slot.get(at);
      if (where !== undefined && value !== null && value !== undefined) column[where] = value;
    });
    return column;
  });
  return { x, y };
}
