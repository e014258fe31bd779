import { describe, expect, it } from "vitest";
import type { RenderLoop } from "../src/charts/render_loop";
import { Viewport } from "../src/charts/viewport.svelte";
import { ChartView } from "../src/live/chart_view.svelte";
import type { RunModel } from "../src/live/run_model.svelte";
import type { Slide } from "../src/stream/slide";

function viewOf(run: { running: boolean; duration: number; story?: object }): ChartView {
  const model = run as unknown as RunModel;
  return new ChartView(model, {} as Slide, new Viewport(0.01), {} as RenderLoop);
}

describe("a review opens on the fault", () => {
  const reviewOf = (duration: number, onset_s?: number) =>
    viewOf({
      running: false,
      duration,
      story: { episodes: onset_s === undefined ? [] : [{ onset_s }], changes: [], events: [] },
    });
  it.each([
    ["a short run as a whole", reviewOf(30, 10), 30, [0, 30]],
    ["a long run around its change", reviewOf(600, 400), 600, [395, 415]],
    ["a change in the first seconds", reviewOf(600, 2), 600, [0, 20]],
    ["a change in the last seconds", reviewOf(600, 598), 600, [580, 600]],
    ["a long run without a change as a whole", reviewOf(600), 600, [0, 600]],
  ] as const)("%s", (_, chartView, duration, seen) => {
    chartView.openReview();
    expect(chartView.view.range(duration)).toEqual(seen);
  });
  it("but leaves what somebody has chosen to see", () => {
    const chartView = reviewOf(600, 400);
    chartView.view.span = 5;
    chartView.openReview();
    expect(chartView.view.range(600)).toEqual([595, 600]);
  });
});

describe("the button of the whole run", () => {
  it("is pressed in the review of a long recording only when all of it is shown", () => {
    const chartView = viewOf({ running: false, duration: 600 });
    expect(chartView.following).toBe(false);
    chartView.follow();
    expect(chartView.following).toBe(true);
    expect(chartView.view.range(600)).toEqual([0, 600]);
    chartView.view.span = 10;
    expect(chartView.following).toBe(false);
  });
  it("is pressed at once where the first view shows all", () => {
    expect(viewOf({ running: false, duration: 20 }).following).toBe(true);
  });
  it("is that of the newest samples while the run goes on", () => {
    const chartView = viewOf({ running: true, duration: 600 });
    expect(chartView.following).toBe(true);
    chartView.view.pan(-0.5, 100);
    expect(chartView.following).toBe(false);
  });
});
