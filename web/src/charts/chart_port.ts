/** The interface of a chart for the page, independent of the library that draws it. */

export interface TraceStyle {
  label: string;
  color: string;
  dash?: number[];
  /** Hold the value until the next sample, as a converter does. */
  stepped?: boolean;
}

export interface Marker {
  kind:
    | "fault"
    | "detected"
    | "isolated"
    | "compensated"
    | "planned"
    | "cursorA"
    | "cursorB"
    | "trip"
    | "stopped";
  timeS: number;
  label: string;
}

/** A straight line over a span of run time. */
export interface Segment {
  fromS: number;
  from: number;
  toS: number;
  to: number;
}

/** A line that is no trace: what a signal should be, or would have been. */
export interface Curve extends TraceStyle {
  timesS: ArrayLike<number>;
  values: ArrayLike<number>;
}

/** The decoration behind and over the traces. */
export interface Decoration {
  markers: Marker[];
  /** Horizontal lines: the nominal parameter. */
  levels: number[];
  /** Range of a healthy estimate. */
  band: [number, number] | null;
  /** Time in which the estimators' windows still contain samples from before the fault. */
  settling: [number, number][];
  /** Times without samples; those without a value of any curve are found. */
  gaps: [number, number][];
  /** Whether markers have their label beside their symbol. */
  labels: boolean;
  /** The span between the cursors. */
  selection?: [number, number] | null;
  /** Spans that somebody has marked. */
  evidence?: [number, number][];
  /** The span that a lens shows. */
  lens?: [number, number] | null;
  /** Lines fitted to the traces. */
  fits?: Segment[];
  /** Lines behind the traces. */
  curves?: Curve[];
}

export interface ChartColors {
  text: string;
  grid: string;
  fault: string;
  detect: string;
  nominal: string;
  band: string;
  settle: string;
  gap: string;
  select: string;
}

export interface ChartOptions {
  traces: TraceStyle[];
  colors: ChartColors;
  fonts: { axis: string; label: string };
  /** Name and unit of the horizontal axis. */
  xName: string;
  /** The pointer moved over the chart: run time under it, null when it left. */
  onHover?: (timeS: number | null) => void;
  /** A time span was selected by dragging. */
  onSelect?: (fromS: number, toS: number) => void;
  /** A click without drag. */
  onPick?: (timeS: number) => void;
}

export type Columns = [Float64Array, ...Float32Array[]];

export interface ChartPort {
  resize(width: number, height: number): void;
  /** Draws `columns` (time first) in the given ranges. */
  draw(columns: Columns, x: [number, number], y: [number, number], decoration: Decoration): void;
  /** The plotting area on the screen: its left edge and width, in CSS pixels. */
  plotArea(): { left: number; width: number };
  destroy(): void;
}

export type ChartFactory = (host: HTMLElement, options: ChartOptions) => ChartPort;
