import type { ChartColors, Decoration, Marker } from "./chart_port";

/** Position of a chart's plotting area on the canvas, in device pixels. */
export interface Area {
  left: number;
  top: number;
  width: number;
  height: number;
  x(timeS: number): number;
  y(value: number): number;
  /** Device pixels per CSS pixel. */
  ratio: number;
}

type Context = CanvasRenderingContext2D;

const SYMBOL: Record<Marker["kind"], string> = {
  fault: "▼",
  planned: "▽",
  detected: "◆",
  isolated: "●",
  trip: "✖",
  cursorA: "A",
  cursorB: "B",
};
const DASH: Record<Marker["kind"], number[]> = {
  fault: [],
  planned: [2, 4],
  detected: [5, 3],
  isolated: [1, 3],
  trip: [],
  cursorA: [],
  cursorB: [],
};

export function drawBehind(
  context: Context,
  area: Area,
  decoration: Decoration,
  colors: ChartColors,
): void {
  context.save();
  clip(context, area);
  for (const span of decoration.settling) fillSpan(context, area, span, colors.settle);
  for (const gap of decoration.gaps) hatchSpan(context, area, gap, colors.gap);
  if (decoration.band) {
    const top = area.y(decoration.band[1]);
    const height = Math.max(area.ratio, area.y(decoration.band[0]) - top);
    context.fillStyle = colors.band;
    context.fillRect(area.left, top, area.width, height);
  }
  context.strokeStyle = colors.nominal;
  context.lineWidth = 1;
  context.setLineDash([1.5 * area.ratio, 2.5 * area.ratio]);
  for (const level of decoration.levels) {
    const y = Math.round(area.y(level)) + 0.5;
    line(context, area.left, y, area.left + area.width, y);
  }
  context.restore();
}

export function drawMarkers(
  context: Context,
  area: Area,
  decoration: Decoration,
  colors: ChartColors,
  font: string,
): void {
  context.save();
  context.font = font;
  context.textAlign = "left";
  context.textBaseline = "top";
  const lineHeight = 13 * area.ratio;
  const taken: { row: number; from: number; to: number }[] = [];
  for (const marker of decoration.markers) {
    const x = Math.round(area.x(marker.timeS)) + 0.5;
    if (x < area.left || x > area.left + area.width) continue;
    const color =
      marker.kind === "fault" || marker.kind === "planned" || marker.kind === "trip"
        ? colors.fault
        : marker.kind === "cursorA" || marker.kind === "cursorB"
          ? colors.text
          : colors.detect;
    context.strokeStyle = color;
    context.lineWidth = area.ratio;
    context.setLineDash(DASH[marker.kind].map((length) => length * area.ratio));
    line(context, x, area.top, x, area.top + area.height);
    const text =
      decoration.labels && marker.label
        ? `${SYMBOL[marker.kind]} ${marker.label}`
        : SYMBOL[marker.kind];
    const width = context.measureText(text).width;
    const space = 4 * area.ratio;
    const right = area.left + area.width;
    const leftSide = marker.kind === "fault" || x + space + width > right;
    const from = leftSide && x - space - width > area.left ? x - space - width : x + space;
    let row = 0;
    while (taken.some((t) => t.row === row && t.from < from + width && from < t.to)) row++;
    taken.push({ row, from: from - space, to: from + width + space });
    const top = area.top + 2 * area.ratio + row * lineHeight;
    context.setLineDash([]);
    context.fillStyle = colors.surface;
    context.globalAlpha = 0.82;
    context.fillRect(from - 1, top - 1, width + 2, lineHeight);
    context.globalAlpha = 1;
    context.fillStyle = color;
    context.fillText(text, from, top);
  }
  context.restore();
}

function clip(context: Context, area: Area): void {
  context.beginPath();
  context.rect(area.left, area.top, area.width, area.height);
  context.clip();
}

function line(context: Context, x0: number, y0: number, x1: number, y1: number): void {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}

function fillSpan(context: Context, area: Area, span: [number, number], color: string): void {
  const from = Math.max(area.left, area.x(span[0]));
  const to = Math.min(area.left + area.width, area.x(span[1]));
  if (to <= from) return;
  context.fillStyle = color;
  context.fillRect(from, area.top, to - from, area.height);
}

function hatchSpan(context: Context, area: Area, span: [number, number], color: string): void {
  const from = Math.max(area.left, area.x(span[0]));
  const to = Math.min(area.left + area.width, Math.max(area.x(span[1]), from + 2 * area.ratio));
  if (to <= from) return;
  context.save();
  context.beginPath();
  context.rect(from, area.top, to - from, area.height);
  context.clip();
  context.fillStyle = color;
  context.globalAlpha = 0.4;
  context.fillRect(from, area.top, to - from, area.height);
  context.globalAlpha = 1;
  context.strokeStyle = color;
  context.lineWidth = area.ratio;
  const step = 7 * area.ratio;
  for (let x = from - area.height; x < to; x += step) {
    line(context, x, area.top + area.height, x + area.height, area.top);
  }
  context.restore();
}
