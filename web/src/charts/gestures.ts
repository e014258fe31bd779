/** What wheel and fingers do on a chart. Dragging with a mouse is the chart's own. */
export interface GestureActions {
  /** The plotting area on the screen, CSS pixels. */
  area(): { left: number; width: number };
  /** [from, to] in run time that it shows. */
  range(): [number, number];
  show(fromS: number, toS: number): void;
  zoom(factor: number, aroundS: number): void;
  /** A double click or double tap. */
  reset(): void;
  /** The wheel was turned without a key: the page scrolls, and the user may be told how to zoom. */
  wheelOnly(): void;
  /** The cursor that can be gripped within `reachS` of a time, or null. */
  grip(timeS: number, reachS: number): "A" | "B" | null;
  moveCursor(which: "A" | "B", timeS: number): void;
}

/** A finger: its place as a share of the plot's width, and the run time that it holds. */
export interface Finger {
  place: number;
  timeS: number;
}

const CLOSEST_FINGERS = 0.05;
const WHEEL_STEP_MAX = 40;
const WHEEL_SCALE = 100;
const WHEEL_LINE_PX = 16;
const MOUSE_REACH_PX = 6;
const TOUCH_REACH_PX = 22;
const TAP_PX = 10;
const DOUBLE_TAP_MS = 350;

/** The view [from, to] in which each finger is at the time that it holds; `spanS` is that of now. */
export function heldView(fingers: Finger[], spanS: number): [number, number] {
  const [first, second] = fingers;
  if (!first) return [0, spanS];
  let span = spanS;
  if (second) {
    const apart = second.place - first.place;
    const held = second.timeS - first.timeS;
    if (Math.abs(apart) >= CLOSEST_FINGERS && held / apart > 0) span = held / apart;
  }
  const centre = (pick: (finger: Finger) => number) =>
    second ? (pick(first) + pick(second)) / 2 : pick(first);
  const from = centre((finger) => finger.timeS) - centre((finger) => finger.place) * span;
  return [from, from + span];
}

/** Factor of the span for one event of a wheel or of a pinch on a touch pad. */
export function wheelFactor(deltaPx: number): number {
  const step = Math.min(WHEEL_STEP_MAX, Math.max(-WHEEL_STEP_MAX, deltaPx));
  return Math.exp(step / WHEEL_SCALE);
}

/** @returns a function that ends it */
export function attachGestures(host: HTMLElement, actions: GestureActions): () => void {
  const fingers = new Map<number, Finger>();
  let gripped: { pointer: number; which: "A" | "B" } | null = null;
  let afterGrip = false;
  let tap: { x: number; at: number } | null = null;
  let lastTap: { x: number; at: number } | null = null;

  const placeOf = (clientX: number) => {
    const { left, width } = actions.area();
    return (clientX - left) / Math.max(1, width);
  };
  const timeOf = (clientX: number) => {
    const [from, to] = actions.range();
    return from + placeOf(clientX) * (to - from);
  };
  const secondsOf = (pixels: number) => {
    const [from, to] = actions.range();
    return (pixels / Math.max(1, actions.area().width)) * (to - from);
  };

  function onWheel(event: WheelEvent): void {
    const unit = event.deltaMode === 0 ? 1 : WHEEL_LINE_PX;
    const sideways = event.shiftKey ? event.deltaX || event.deltaY : event.deltaX;
    if (event.ctrlKey || event.metaKey) {
      event.preventDefault();
      actions.zoom(wheelFactor(event.deltaY * unit), timeOf(event.clientX));
    } else if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
      event.preventDefault();
      const [from, to] = actions.range();
      const by = Math.max(-from, secondsOf(sideways * unit));
      actions.show(from + by, to + by);
    } else {
      actions.wheelOnly();
    }
  }

  function onDown(event: PointerEvent): void {
    const touch = event.pointerType !== "mouse";
    if (!touch && event.button !== 0) return;
    const reach = secondsOf(touch ? TOUCH_REACH_PX : MOUSE_REACH_PX);
    const which = fingers.size === 0 ? actions.grip(timeOf(event.clientX), reach) : null;
    if (which) {
      gripped = { pointer: event.pointerId, which };
      host.setPointerCapture(event.pointerId);
      return;
    }
    if (!touch) return;
    fingers.set(event.pointerId, { place: placeOf(event.clientX), timeS: timeOf(event.clientX) });
    tap = fingers.size === 1 ? { x: event.clientX, at: event.timeStamp } : null;
  }

  function onMove(event: PointerEvent): void {
    if (gripped?.pointer === event.pointerId) {
      actions.moveCursor(gripped.which, timeOf(event.clientX));
      return;
    }
    const finger = fingers.get(event.pointerId);
    if (!finger) return;
    if (tap && Math.abs(event.clientX - tap.x) < TAP_PX) return;
    tap = null;
    finger.place = placeOf(event.clientX);
    const [from, to] = actions.range();
    const [left, right] = heldView([...fingers.values()], to - from);
    actions.show(Math.max(0, left), Math.max(0, left) + (right - left));
  }

  function onUp(event: PointerEvent): void {
    if (gripped?.pointer === event.pointerId) {
      gripped = null;
      afterGrip = event.type === "pointerup";
      return;
    }
    if (!fingers.delete(event.pointerId)) return;
    // a finger that stays holds the time that is under it now
    for (const finger of fingers.values()) {
      const [from, to] = actions.range();
      finger.timeS = from + finger.place * (to - from);
    }
    if (event.type !== "pointerup" || !tap) return;
    const again = lastTap && event.timeStamp - lastTap.at < DOUBLE_TAP_MS;
    if (again && Math.abs(event.clientX - (lastTap?.x ?? 0)) < TOUCH_REACH_PX) {
      actions.reset();
      lastTap = null;
    } else {
      lastTap = { x: event.clientX, at: event.timeStamp };
    }
  }

  /** Two fingers are a zoom of the chart, never a scroll of the page. */
  function onTouch(event: TouchEvent): void {
    if (event.touches.length > 1 || gripped) event.preventDefault();
  }
  /** The chart selects nothing while a cursor is dragged, and a drag is no click. */
  function onMouseDown(event: MouseEvent): void {
    if (gripped) event.stopPropagation();
  }
  function onClick(event: MouseEvent): void {
    if (afterGrip) event.stopPropagation();
    afterGrip = false;
  }

  const listeners: [string, (event: never) => void, AddEventListenerOptions?][] = [
    ["wheel", onWheel, { passive: false }],
    ["pointerdown", onDown],
    ["pointermove", onMove],
    ["pointerup", onUp],
    ["pointercancel", onUp],
    ["touchstart", onTouch, { passive: false }],
    ["touchmove", onTouch, { passive: false }],
    ["mousedown", onMouseDown, { capture: true }],
    ["click", onClick, { capture: true }],
    ["dblclick", () => actions.reset()],
  ];
  for (const [kind, listener, options] of listeners) {
    host.addEventListener(kind, listener as EventListener, options);
  }
  host.style.touchAction = "pan-y";
  return () => {
    for (const [kind, listener, options] of listeners) {
      host.removeEventListener(kind, listener as EventListener, options);
    }
    host.style.touchAction = "";
  };
}
