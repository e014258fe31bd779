import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { ChartView } from "../src/live/chart_view.svelte";
import { type Actions, shortcuts } from "../src/live/shortcuts";

let onKey: (event: object) => void = () => {};
let dialog: object | null = null;
const stop = vi.fn();
const close = vi.fn(() => false);

beforeEach(() => {
  vi.stubGlobal("addEventListener", (_: string, listener: typeof onKey) => {
    onKey = listener;
  });
  vi.stubGlobal("removeEventListener", () => {});
  vi.stubGlobal("document", { querySelector: () => dialog });
  shortcuts({} as ChartView, { stop, close } as unknown as Actions);
});
afterEach(() => {
  vi.unstubAllGlobals();
  vi.clearAllMocks();
  dialog = null;
});
function openDialog(): void {
  dialog = {};
}
const pressEsc = (timeStamp: number, more: object = {}) =>
  onKey({ key: "Escape", timeStamp, target: {}, ...more });

it("Esc stops the run when nothing is open", () => {
  pressEsc(0);
  expect(stop).toHaveBeenCalledTimes(1);
});

it.each([
  ["a sheet", () => close.mockReturnValueOnce(true), {}],
  ["a dialog", openDialog, {}],
  ["a menu", () => {}, { defaultPrevented: true }],
])("Esc that closes %s does not stop the run, nor does a second one at once", (_, open, more) => {
  open();
  pressEsc(5000, more);
  dialog = null;
  pressEsc(5900);
  pressEsc(6500, { repeat: true });
  expect(stop).not.toHaveBeenCalled();
  pressEsc(6500);
  expect(stop).toHaveBeenCalledTimes(1);
});
