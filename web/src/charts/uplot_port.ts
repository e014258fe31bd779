import uPlot from "uplot";
import { significant } from "../i18n/numbers";
import "uplot/dist/uPlot.min.css";
import type { ChartFactory, ChartOptions, ChartPort, Columns, Decoration } from "./chart_port";
import { type Area, drawBehind, drawMarkers, LANE } from "./decoration";
import { emptySpans, nanGaps } from "./nan_gaps";

const EMPTY: Decoration = {
  markers: [],
  levels: [],
  band: null,
  settling: [],
  gaps: [],
  labels: true,
};
const CLICK_PIXELS = 3;
/** A narrower one is a break in the curve, and no more. */
const HATCH_PIXELS = 6;

/**
 * uPlot behind ChartPort. Lines are one device pixel wide, because the browser's rasteriser
 * draws these fastest; 1.25 pixels take four times as long.
 */
function inPixels(plot: uPlot, [from, to]: [number, number]): [number, number] {
  return [plot.valToPos(from, "x", true), plot.valToPos(to, "x", true)];
}

class UplotPort implements ChartPort {
  private plot: uPlot;
  private decoration: Decoration = EMPTY;
  private x: [number, number] = [0, 1];
  private y: [number, number] = [0, 1];
  private ratio = devicePixelRatio;

  constructor(
    private readonly host: HTMLElement,
    private readonly options: ChartOptions,
  ) {
    this.plot = this.make(300, 150);
  }

  resize(width: number, height: number): void {
    if (devicePixelRatio !== this.ratio) {
      this.ratio = devicePixelRatio;
      this.plot.destroy();
      this.plot = this.make(width, height);
      return;
    }
    if (width === this.plot.width && height === this.plot.height) return;
    this.plot.setSize({ width, height });
  }

  draw(columns: Columns, x: [number, number], y: [number, number], decoration: Decoration): void {
    this.decoration = decoration;
    this.x = x;
    this.y = y;
    this.plot.batch(() => {
      this.plot.setData(columns as unknown as uPlot.AlignedData, false);
      this.plot.setScale("y", { min: y[0], max: y[1] });
      this.plot.setScale("x", { min: x[0], max: x[1] });
    });
  }

  plotArea(): { left: number; width: number } {
    return this.plot.over.getBoundingClientRect();
  }

  destroy(): void {
    this.plot.destroy();
  }

  private area(plot: uPlot): Area {
    const { left, top, width, height } = plot.bbox;
    return {
      left,
      top,
      width,
      height,
      x: (timeS) => plot.valToPos(timeS, "x", true),
      y: (value) => plot.valToPos(value, "y", true),
      ratio: this.ratio,
    };
  }

  private make(width: number, height: number): uPlot {
    const { traces, colors, fonts, xName } = this.options;
    const scaled = (font: string) =>
      font.replace(/(\d+)px/, (_, px) => `${Math.round(Number(px) * this.ratio)}px`);
    const line = 1 / devicePixelRatio;
    const axis: uPlot.Axis = {
      stroke: colors.text,
      font: fonts.axis,
      labelFont: fonts.axis,
      grid: { stroke: colors.grid, width: line },
      ticks: { show: false },
      border: { show: false },
      values: (_, splits) => splits.map(tick),
    };
    const options: uPlot.Options = {
      width,
      height,
      pxAlign: 1,
      legend: { show: false },
      padding: [LANE, 8, 0, 0],
      scales: {
        x: { time: false, auto: false, range: () => this.x },
        y: { auto: false, range: () => this.y },
      },
      axes: [
        { ...axis, size: 24, gap: 5, space: 48 },
        { ...axis, size: 48, gap: 5, space: 26 },
      ],
      series: [
        {},
        ...traces.map((trace): uPlot.Series => {
          const stepped = trace.stepped ? uPlot.paths.stepped?.({ align: 1 }) : undefined;
          return {
            label: trace.label,
            stroke: trace.color,
            width: line,
            dash: trace.dash,
            points: { show: false },
            spanGaps: false,
            // uPlot knows null alone, and typed arrays have none
            gaps: (plot, series, first, last) =>
              nanGaps(plot.data[0], plot.data[series] ?? [], first, last).map((ends) =>
                inPixels(plot, ends),
              ),
            ...(stepped ? { paths: stepped } : {}),
          };
        }),
      ],
      cursor: {
        y: false,
        points: { show: false },
        sync: { key: "faultlab" },
        drag: { x: true, y: false, setScale: false, dist: CLICK_PIXELS },
        bind: {
          dblclick: () => () => null,
        },
      },
      hooks: {
        drawAxes: [
          (plot) => {
            const area = this.area(plot);
            const wide = ([from, to]: [number, number]) =>
              area.x(to) - area.x(from) >= HATCH_PIXELS;
            const empty = emptySpans(plot.data).filter(wide);
            const lost = this.decoration.gaps.filter(
              ([from, to]) => !empty.some((span) => span[0] < to && span[1] > from),
            );
            drawBehind(plot.ctx, area, { ...this.decoration, gaps: [...lost, ...empty] }, colors);
            nameAxis(plot.ctx, area, xName, colors.text, scaled(fonts.axis));
          },
        ],
        draw: [
          (plot) =>
            drawMarkers(plot.ctx, this.area(plot), this.decoration, colors, scaled(fonts.label)),
        ],
        setCursor: [
          (plot) => {
            const left = plot.cursor.left ?? -1;
            this.options.onHover?.(left < 0 ? null : plot.posToVal(left, "x"));
          },
        ],
        setSelect: [
          (plot) => {
            const { left, width: span } = plot.select;
            if (span < CLICK_PIXELS) return;
            this.options.onSelect?.(plot.posToVal(left, "x"), plot.posToVal(left + span, "x"));
            plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          },
        ],
        ready: [
          (plot) => {
            plot.over.addEventListener("click", () => {
              const left = plot.cursor.left ?? -1;
              if (left >= 0) this.options.onPick?.(plot.posToVal(left, "x"));
            });
          },
        ],
      },
    };
    const empty = [new Float64Array(0), ...traces.map(() => new Float32Array(0))];
    return new uPlot(options, empty as unknown as uPlot.AlignedData, this.host);
  }
}

/** Writes the name of the horizontal axis in the corner left of its numbers. */
function nameAxis(
  context: CanvasRenderingContext2D,
  area: Area,
  name: string,
  color: string,
  font: string,
): void {
  context.save();
  context.font = font;
  context.fillStyle = color;
  context.textAlign = "right";
  context.textBaseline = "top";
  context.fillText(name, area.left - 19 * area.ratio, area.top + area.height + 6 * area.ratio);
  context.restore();
}

/** Numbers for which the axis has no room are in thousands: "100k". */
const ROOM = 99_999;

function tick(value: number): string {
  if (Math.abs(value) > ROOM) return `${significant(value / 1000, 6)}k`;
  return significant(value, 6);
}

export const makeUplot: ChartFactory = (host, options) => new UplotPort(host, options);
