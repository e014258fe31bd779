import type { ChartColors, Curve, Decoration, Marker, Segment } from "./chart_port";
import { LOOK } from "./markers";

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

/** Height of the lane for markers above a plot, CSS pixels. */
export const LANE = 15;
/** Of the bar over a marked span, CSS pixels. */
const CAP = 4;

type Context = CanvasRenderingContext2D;

export function drawBehind(
  context: Context,
  area: Area,
  decoration: Decoration,
  colors: ChartColors,
): void {
  context.save();
  clip(context, area);
  for (const span of decoration.settling) fillSpan(context, area, span, colors.settle);
  if (decoration.selection) fillSpan(context, area, decoration.selection, colors.select);
  for (const span of decoration.evidence ?? []) capSpan(context, area, span, colors);
  if (decoration.lens) frameSpan(context, area, decoration.lens, colors);
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
  for (const curve of decoration.curves ?? []) drawCurve(context, area, curve);
  context.restore();
}

function drawCurve(context: Context, area: Area, curve: Curve): void {
  const { timesS, values } = curve;
  context.strokeStyle = curve.color;
  context.lineWidth = area.ratio;
  context.setLineDash((curve.dash ?? []).map((length) => length * area.ratio));
  context.beginPath();
  let drawing = false;
  for (let at = 0; at < timesS.length; at++) {
    const value = values[at] as number;
    // One corner beyond each edge, so that the line reaches it.
    const next = area.x(timesS[at + 1] ?? (timesS[at] as number));
    const before = area.x(timesS[at - 1] ?? (timesS[at] as number));
    const away = next < area.left || before > area.left + area.width;
    if (away || !Number.isFinite(value)) {
      drawing = false;
      continue;
    }
    const x = area.x(timesS[at] as number);
    if (drawing) context.lineTo(x, area.y(value));
    else context.moveTo(x, area.y(value));
    drawing = true;
  }
  context.stroke();
}

/**
 * Draws the marker lines, and their symbols and labels in the lane above the plot, where they hide
 * no trace. Symbols that would overlap stand in a row; a label that has no room is left out.
 */
export function drawMarkers(
  context: Context,
  area: Area,
  decoration: Decoration,
  colors: ChartColors,
  font: string,
): void {
  context.save();
  drawFits(context, area, decoration.fits ?? [], colors.text);
  context.font = font;
  context.textBaseline = "middle";
  const middle = area.top - (LANE / 2) * area.ratio;
  const shown = decoration.markers
    .map((marker) => ({ marker, x: Math.round(area.x(marker.timeS)) + 0.5 }))
    .filter(({ x }) => x >= area.left && x <= area.left + area.width);
  for (const { marker, x } of shown) {
    context.strokeStyle = colors[LOOK[marker.kind].color];
    context.lineWidth = area.ratio;
    context.setLineDash((LOOK[marker.kind].dash ?? []).map((length) => length * area.ratio));
    line(context, x, area.top, x, area.top + area.height);
  }
  const half = (context.measureText(LOOK.fault.symbol).width + area.ratio) / 2;
  const groups = groupsOf(shown, half);
  context.textAlign = "center";
  for (const group of groups) {
    group.members.forEach(({ kind }, at) => {
      context.fillStyle = colors[LOOK[kind].color];
      context.fillText(LOOK[kind].symbol, group.from + (2 * at + 1) * half, middle);
    });
  }
  if (decoration.labels) labelGroups(context, area, groups, colors, middle);
  context.restore();
}

interface Group {
  members: Marker[];
  from: number;
  to: number;
}

/** Markers so close that their symbols, `half` wide on each side, stand in a row. */
export function groupsOf(shown: { marker: Marker; x: number }[], half: number): Group[] {
  const groups: Group[] = [];
  for (const { marker, x } of shown) {
    const last = groups.at(-1);
    if (last && x - half < last.to) {
      last.members.push(marker);
      last.to += 2 * half;
    } else {
      groups.push({ members: [marker], from: x - half, to: x + half });
    }
  }
  return groups;
}

/** The label of a fault stands left of its group, those of the others right of it. */
function labelGroups(
  context: Context,
  area: Area,
  groups: Group[],
  colors: ChartColors,
  middle: number,
): void {
  context.textAlign = "left";
  const space = 3 * area.ratio;
  const room = { from: area.left, to: area.left + area.width };
  const taken: Span[] = groups.map(({ from, to }) => ({ from, to }));
  for (const group of groups) {
    const named = group.members.filter(({ label }) => label);
    const faults = named.filter(({ kind }) => kind === "fault");
    const others = named.filter(({ kind }) => kind !== "fault");
    for (const part of [faults, others]) {
      const [first] = part;
      if (!first) continue;
      const all = part.map(({ label }) => label).join(", ");
      // all labels of the group if they have room, else the first
      for (const text of [all, first.label]) {
        const width = context.measureText(text).width;
        const span = placeLabel(group, space, width, room, taken, part === faults);
        if (!span) continue;
        taken.push(span);
        context.fillStyle = colors[LOOK[first.kind].color];
        context.fillText(text, span.from, middle);
        break;
      }
    }
  }
}

export interface Span {
  from: number;
  to: number;
}

/**
 * Where a label of `width` stands, `space` beside its symbols: right of them, or left if it is
 * `leftFirst` or has no room there.
 * @returns null if something is in the way on both sides
 */
export function placeLabel(
  symbols: Span,
  space: number,
  width: number,
  room: Span,
  taken: Span[],
  leftFirst: boolean,
): Span | null {
  const sides = [
    { from: symbols.to + space, to: symbols.to + space + width },
    { from: symbols.from - space - width, to: symbols.from - space },
  ];
  if (leftFirst) sides.reverse();
  const free = (side: Span) =>
    side.from >= room.from &&
    side.to <= room.to &&
    !taken.some((other) => other.from < side.to && side.from < other.to);
  return sides.find(free) ?? null;
}

function drawFits(context: Context, area: Area, fits: Segment[], color: string): void {
  if (fits.length === 0) return;
  context.save();
  clip(context, area);
  context.strokeStyle = color;
  context.lineWidth = 1.5 * area.ratio;
  context.setLineDash([8 * area.ratio, 4 * area.ratio]);
  for (const fit of fits) {
    line(context, area.x(fit.fromS), area.y(fit.from), area.x(fit.toS), area.y(fit.to));
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

function frameSpan(
  context: Context,
  area: Area,
  span: [number, number],
  colors: ChartColors,
): void {
  fillSpan(context, area, span, colors.select);
  const from = area.x(span[0]);
  context.strokeStyle = colors.text;
  context.lineWidth = area.ratio;
  context.setLineDash([]);
  context.strokeRect(
    from,
    area.top + area.ratio / 2,
    area.x(span[1]) - from,
    area.height - area.ratio,
  );
}

/** A bar along the top, with a line down at either end. */
function capSpan(context: Context, area: Area, span: [number, number], colors: ChartColors): void {
  fillSpan(context, area, span, colors.select);
  const [from, to] = [area.x(span[0]), area.x(span[1])];
  context.fillStyle = colors.text;
  context.fillRect(from, area.top, Math.max(to - from, area.ratio), CAP * area.ratio);
  context.strokeStyle = colors.text;
  context.lineWidth = area.ratio;
  context.setLineDash([2 * area.ratio, 2 * area.ratio]);
  for (const x of [from, to]) line(context, x, area.top, x, area.top + area.height);
}

function hatchSpan(context: Context, area: Area, span: [number, number], color: string): void {
  const from = Math.max(area.left, area.x(span[0]));
  const to = Math.min(area.left + area.width, Math.max(area.x(span[1]), from + 2 * area.ratio));
  if (to <= from) return;
  context.save();
  clip(context, { ...area, left: from, width: to - from });
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
