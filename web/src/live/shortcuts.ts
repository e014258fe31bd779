export interface Actions {
  pause(): void;
  pan(share: number): void;
  zoom(factor: number): void;
  live(): void;
  fit(): void;
  nominal(): void;
  stop(): void;
  /** Closes what lies over the page and is no dialog; false: nothing did. */
  close(): boolean;
  marker(): void;
  table(): void;
  cursor(which: "A" | "B"): void;
  /** Moves the cursor that was set last. */
  moveCursor(steps: number, bySample: boolean): void;
  measure(): void;
  selectView(): void;
  lens(): void;
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
export function shortcuts(actions: Actions): () => void {
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
    const done = act(event, target, actions);
    if (done) event.preventDefault();
  };
  addEventListener("keydown", onKey);
  return () => removeEventListener("keydown", onKey);
}

function act({ key, shiftKey }: KeyboardEvent, target: Element, actions: Actions): boolean {
  const onSlider = target.closest(ARROWS) !== null;
  if (key === " ") {
    if (target.closest(PRESSABLE)) return false;
    actions.pause();
  } else if (key === "ArrowLeft" || key === "ArrowRight") {
    if (onSlider) return false;
    const way = key === "ArrowLeft" ? -1 : 1;
    if (shiftKey) actions.moveCursor(way, false);
    else actions.pan(0.1 * way);
  } else if (key === "ArrowUp" || key === "ArrowDown") {
    return zoomKey(key, onSlider, actions);
  } else if (key === "+" || key === "=") actions.zoom(0.5);
  else if (key === "-") actions.zoom(2);
  else if (key === "," || key === ".") actions.moveCursor(key === "," ? -1 : 1, true);
  else if (key === "0") actions.nominal();
  else if (key === "?") actions.help();
  else {
    switch (key.toLowerCase()) {
      case "l":
        actions.live();
        break;
      case "f":
        actions.fit();
        break;
      case "m":
        actions.marker();
        break;
      case "t":
        actions.table();
        break;
      case "a":
        actions.cursor("A");
        break;
      case "b":
        actions.cursor("B");
        break;
      case "c":
        actions.measure();
        break;
      case "s":
        actions.selectView();
        break;
      case "z":
        actions.lens();
        break;
      default:
        return false;
    }
  }
  return true;
}

function zoomKey(key: string, onSlider: boolean, actions: Actions): boolean {
  // Up and down keys scroll the page if it is longer than the screen.
  const scrolls = document.documentElement.scrollHeight > innerHeight + 4;
  if (onSlider || scrolls) return false;
  actions.zoom(key === "ArrowUp" ? 0.5 : 2);
  return true;
}
