import type { Marker } from "./chart_port";

interface Look {
  symbol: string;
  color: "fault" | "detect" | "text";
  dash?: number[];
}
/** Red is for what is wrong with the rig; cursors and the end of a run have the colour of text. */
export const LOOK: Record<Marker["kind"], Look> = {
  fault: { symbol: "▼", color: "fault" },
  planned: { symbol: "▽", color: "fault", dash: [2, 4] },
  detected: { symbol: "◆", color: "detect", dash: [5, 3] },
  isolated: { symbol: "●", color: "detect", dash: [1, 3] },
  compensated: { symbol: "✚", color: "detect", dash: [6, 2] },
  trip: { symbol: "✖", color: "fault" },
  stopped: { symbol: "■", color: "text" },
  cursorA: { symbol: "A", color: "text" },
  cursorB: { symbol: "B", color: "text" },
};
