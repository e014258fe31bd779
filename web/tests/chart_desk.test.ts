import { describe, expect, it } from "vitest";
import type { RenderLoop } from "../src/charts/render_loop";
import { Viewport } from "../src/charts/viewport.svelte";
import { ChartDesk } from "../src/live/chart_desk.svelte";
import type { RunModel } from "../src/live/run_model.svelte";
import type { Slide } from "../src/stream/slide";

function deskOf(run: { running: boolean; duration: number; story?: object }): ChartDesk {
  const model = run as unknown as RunModel;
  return new ChartDesk(model, {} as Slide, new Viewport(0.01), {} as RenderLoop);
}

describe("a review opens on the fault", () => {
  const reviewOf = (duration: number, onsetS?: number) =>
    deskOf({
      running: false,
      duration,
      story: { episodes: onsetS === undefined ? [] : [{ onsetS }], changes: [], events: [] },
    });
  it.each([
    ["a short run as a whole", reviewOf(30, 10), 30, [0, 30]],
    ["a long run around its change", reviewOf(600, 400), 600, [395, 415]],
    ["a change in the first seconds", reviewOf(600, 2), 600, [0, 20]],
    ["a change in the last seconds", reviewOf(600, 598), 600, [580, 600]],
    ["a long run without a change as a whole", reviewOf(600), 600, [0, 600]],
  ] as const)("%s", (_, desk, duration, seen) => {
    desk.openReview();
    expect(desk.view.range(duration)).toEqual(seen);
  });
  it("but leaves what somebody has chosen to see", () => {
    const desk = reviewOf(600, 400);
    desk.view.setSpan(5);
    desk.openReview();
    expect(desk.view.range(600)).toEqual([595, 600]);
  });
});

describe("the button of the whole run", () => {
  it("is pressed in the review of a long recording only when all of it is shown", () => {
    const desk = deskOf({ running: false, duration: 600 });
    expect(desk.following).toBe(false);
    desk.follow();
    expect(desk.following).toBe(true);
    expect(desk.view.range(600)).toEqual([0, 600]);
    desk.view.setSpan(10);
    expect(desk.following).toBe(false);
  });
  it("is pressed at once where the first view shows all", () => {
    expect(deskOf({ running: false, duration: 20 }).following).toBe(true);
  });
  it("is that of the newest samples while the run goes on", () => {
    const desk = deskOf({ running: true, duration: 600 });
    expect(desk.following).toBe(true);
    desk.view.pan(-0.5, 100);
    expect(desk.following).toBe(false);
  });
});
