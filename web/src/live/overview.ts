import type { Marker } from "../charts/chart_port";
import { LOOK } from "../charts/markers";
import type { Slide } from "../stream/slide";
import type { Tokens } from "../theme/tokens";

/** The whole run in one strip: lowest and highest value per pixel column, markers, visible window. */
export function drawOverview(
  context: CanvasRenderingContext2D,
  slide: Slide,
  channel: number,
  color: string,
  durationS: number,
  window: [number, number],
  markers: Marker[],
  colors: Tokens,
  ratio: number,
): void {
  const { width, height } = context.canvas;
  context.clearRect(0, 0, width, height);
  const x = (timeS: number) => (timeS / durationS) * width;
  context.fillStyle = colors.band;
  context.fillRect(x(window[0]), 0, x(Math.min(window[1], durationS)) - x(window[0]), height);

  const envelope = columnExtremes(slide, channel, durationS, width);
  let low = Number.POSITIVE_INFINITY;
  let high = Number.NEGATIVE_INFINITY;
  for (const value of envelope) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  const scale = (height - 4 * ratio) / Math.max(high - low, 1e-9);
  const y = (value: number) => height - 2 * ratio - (value - low) * scale;
  context.fillStyle = color;
  for (let column = 0; column < width; column++) {
    const bottom = envelope[2 * column] as number;
    const top = envelope[2 * column + 1] as number;
    if (Number.isFinite(bottom)) {
      context.fillRect(column, y(top), 1, Math.max(1, y(bottom) - y(top)));
    }
  }
  context.strokeStyle = colors.accent;
  context.lineWidth = ratio;
  context.strokeRect(
    x(window[0]) + ratio / 2,
    ratio / 2,
    Math.max(2, x(Math.min(window[1], durationS)) - x(window[0]) - ratio),
    height - ratio,
  );
  for (const marker of markers) {
    context.fillStyle = colors[LOOK[marker.kind].color];
    context.fillRect(x(marker.timeS), 0, Math.max(1, 1.5 * ratio), height);
  }
}

/** [low, high] of each of `width` columns, NaN where there is no sample. */
export function columnExtremes(
  slide: Slide,
  channel: number,
  durationS: number,
  width: number,
): Float64Array {
  const envelope = new Float64Array(2 * width).fill(Number.NaN);
  const perPixel = durationS / slide.period / width;
  const [times, values = new Float32Array(0)] = slide.view(0, durationS, [channel], perPixel);
  for (let at = 0; at < values.length; at++) {
    const value = values[at] as number;
    if (!Number.isFinite(value)) continue;
    const share = (times[at] as number) / durationS;
    const column = Math.min(width - 1, Math.floor(share * width + 1e-9));
    const low = envelope[2 * column] as number;
    const high = envelope[2 * column + 1] as number;
    if (!(value >= low)) envelope[2 * column] = value;
    if (!(value <= high)) envelope[2 * column + 1] = value;
  }
  return envelope;
}
