import type { ChartColors, Marker } from "./chart_port";

type MarkerColors = Pick<ChartColors, "fault" | "detect" | "text">;
/** Red is for what is wrong with the rig; cursors and the end of a run have the colour of text. */
export function colorOf(kind: Marker["kind"], colors: MarkerColors): string {
  switch (kind) {
    case "fault":
    case "planned":
    case "trip":
      return colors.fault;
    case "detected":
    case "isolated":
    case "compensated":
      return colors.detect;
    default:
      return colors.text;
  }
}
