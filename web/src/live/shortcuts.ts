import type { ChartView } from "./chart_view.svelte";

/** What keys do beside the charts. */
export interface Actions {
  nominal(): void;
  stop(): void;
  /** Closes what lies over the page and is no dialog; false: nothing did. */
  close(): boolean;
  help(): void;
}

const KEY = "faultlab.shortcuts";

/** Single-key shortcuts can be switched off (WCAG 2.1.4); Esc always closes or stops. */
export const shortcutPreference = {
  get on(): boolean {
    return localStorage.getItem(KEY) !== "off";
  },
  set on(value: boolean) {
    localStorage.setItem(KEY, value ? "on" : "off");
  },
};

const TEXT = 'input:not([type="range"], [type="checkbox"], [type="radio"]), textarea, select';
const ARROWS = 'input[type="range"], [role="slider"], .scroll-x';
const PRESSABLE = "button, a[href], summary, input";

/** An Esc that is pressed again, after one that closed something, does not stop the run. */
const CLOSED_MS = 1000;

/** Listens for the keys of the live page; the returned function stops it. */
export function shortcuts(chart: ChartView, actions: Actions): () => void {
  let closedAt = Number.NEGATIVE_INFINITY;
  const onEscape = (event: KeyboardEvent) => {
    if (event.defaultPrevented || document.querySelector("dialog[open]") || actions.close()) {
      closedAt = event.timeStamp;
    } else if (!event.repeat && event.timeStamp - closedAt > CLOSED_MS) {
      actions.stop();
    }
  };
  const onKey = (event: KeyboardEvent) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "Escape") return onEscape(event);
    if (event.defaultPrevented || document.querySelector("dialog[open]")) return;
    const target = event.target as Element;
    if (!shortcutPreference.on || target.closest(TEXT)) return;
    const done = act(event, target, chart, actions);
    if (done) event.preventDefault();
  };
  addEventListener("keydown", onKey);
  return () => removeEventListener("keydown", onKey);
}

const zoom = (chart: ChartView, factor: number) => chart.zoom(factor, chart.hover ?? undefined);

const KEYS: Record<string, (chart: ChartView, actions: Actions) => void> = {
  "+": (chart) => zoom(chart, 0.5),
  "=": (chart) => zoom(chart, 0.5),
  "-": (chart) => zoom(chart, 2),
  ",": (chart) => chart.moveCursor(-1, true),
  ".": (chart) => chart.moveCursor(1, true),
  "0": (_, actions) => actions.nominal(),
  "?": (_, actions) => actions.help(),
  l: (chart) => chart.follow(),
  f: (chart) => chart.fit(),
  m: (chart) => chart.nextMarker(),
  t: (chart) => chart.toggleTable(),
  a: (chart) => chart.pinCursor("A"),
  b: (chart) => chart.pinCursor("B"),
  c: (chart) => chart.cursors.toggle(),
  s: (chart) => chart.selectView(),
  z: (chart) => chart.lens.toggle(),
};

function act(
  { key, shiftKey }: KeyboardEvent,
  target: Element,
  chart: ChartView,
  actions: Actions,
): boolean {
  const onSlider = target.closest(ARROWS) !== null;
  if (key === " ") {
    if (target.closest(PRESSABLE)) return false;
    chart.togglePause();
  } else if (key === "ArrowLeft" || key === "ArrowRight") {
    if (onSlider) return false;
    const way = key === "ArrowLeft" ? -1 : 1;
    if (shiftKey) chart.moveCursor(way, false);
    else chart.view.pan(0.1 * way, chart.edge());
  } else if (key === "ArrowUp" || key === "ArrowDown") {
    return zoomKey(key, onSlider, chart);
  } else {
    const action = KEYS[key.toLowerCase()];
    action?.(chart, actions);
    return action !== undefined;
  }
  return true;
}

function zoomKey(key: string, onSlider: boolean, chart: ChartView): boolean {
  // Up and down keys scroll the page if it is longer than the screen.
  const scrolls = document.documentElement.scrollHeight > innerHeight + 4;
  if (onSlider || scrolls) return false;
  zoom(chart, key === "ArrowUp" ? 0.5 : 2);
  return true;
}
