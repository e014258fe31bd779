import { api } from "../api/client";
import type { Run, RunEvent } from "../api/types";
import type { Aligned } from "../figures/figure";
import { moments } from "../live/statistics";
import type { Bench } from "../plant/bench";
import { benches } from "../shell/benches.svelte";
import { readFrames } from "../stream/frame_reader";
import { Slide } from "../stream/slide";

/** One recorded run, prepared for comparison. */
export interface ComparedRun {
  run: Run;
  bench: Bench;
  label: string;
  slide: Slide;
  durationS: number;
  /** Run time of its first fault, 0 without one. */
  onsetS: number;
  verdict: string;
  lastMean(channel: number): number | null;
}

export function firstFault(events: RunEvent[], bench: Bench): RunEvent | undefined {
  return events.find(
    (event) =>
      event.kind === "relay_confirmed" &&
      event.component !== undefined &&
      typeof event.value === "number" &&
      !bench.isNominal(event.component, event.value),
  );
}

export async function loadCompared(id: string): Promise<ComparedRun> {
  const run = await api.run(id);
  const bench = await benches.need(run.bench);
  const period = run.period_s;
  const slide = new Slide(Math.max(run.samples ?? 0, 1), period);
  await readFrames(await api.frames(id), (block) => slide.append(block));
  const fault = firstFault(run.events ?? [], bench);
  const durationS = slide.end * period;
  return {
    run,
    bench,
    label: run.name || run.id,
    slide,
    durationS,
    onsetS: fault ? fault.index * period : 0,
    verdict: run.verdict ?? "",
    lastMean: (channel) => moments(slide, channel, durationS - 1, durationS)?.mean ?? null,
  };
}

/** A channel of several runs on one axis: time since the start, or since each run's fault. */
export function overlay(runs: ComparedRun[], channel: number, onFault: boolean): Aligned {
  const period = Math.min(...runs.map((run) => run.slide.period));
  const shift = (run: ComparedRun) => (onFault ? run.onsetS : 0);
  const from = Math.min(...runs.map((run) => Math.round(-shift(run) / period)));
  const to = Math.max(...runs.map((run) => Math.round((run.durationS - shift(run)) / period)));
  const count = Math.max(0, to - from);
  const x = Float64Array.from({ length: count }, (_, at) => (from + at) * period);
  const y = runs.map((run) => {
    const samples = run.slide.columns[channel] as Float32Array;
    const column = new Float32Array(count);
    for (let at = 0; at < count; at++) {
      // a run of a longer period holds each sample until its next one
      const index = Math.floor(((from + at) * period + shift(run)) / run.slide.period + 1e-6);
      const slot = run.slide.slot(index);
      column[at] = slot < 0 ? Number.NaN : (samples[slot] as number);
    }
    return column;
  });
  return { x, y };
}
