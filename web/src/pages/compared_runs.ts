import { api } from "../api/client";
import type { Run, Story } from "../contract/types";
import type { Aligned } from "../figures/figure";
import { beforeAfter, spanAround } from "../live/before_after";
import type { EstimatorShape } from "../live/estimators";
import type { Bench } from "../plant/bench";
import { benches } from "../shell/benches.svelte";
import { readFrames } from "../stream/frame_reader";
import { Slide } from "../stream/slide";
import { foundWords, happenedWords } from "./run_summary";

const RUNS_MAX = 4;

/** The runs that an address names, each once. */
export function comparedIds(query: URLSearchParams): string[] {
  const named = query.getAll("runs").join(",").split(",");
  return [...new Set(named.filter(Boolean))].slice(0, RUNS_MAX);
}

/** One recorded run, prepared for comparison. */
export interface ComparedRun {
  run: Run;
  bench: Bench;
  label: string;
  slide: Slide;
  durationS: number;
  /** Run time at which the rig was first not nominal; null: it always was. */
  onsetS: number | null;
  happened: string;
  verdict: string;
  /** The means of an estimator after the last change, as on the run's page. */
  after(estimator: EstimatorShape): (number | null)[];
}

export async function loadCompared(id: string): Promise<ComparedRun> {
  const run = await api.run(id);
  const bench = await benches.need(run.bench);
  const period = run.period_s;
  const slide = new Slide(Math.max(run.samples ?? 0, 1), period);
  await readFrames(await api.frames(id), (block) => slide.append(block));
  const { story } = run;
  const durationS = slide.end * period;
  return {
    run,
    bench,
    label: run.name || run.id,
    slide,
    durationS,
    onsetS: story?.episodes[0]?.onset_s ?? null,
    happened: happenedWords(run, bench),
    verdict: foundWords(run, bench),
    after: (estimator) => afterLastChange(slide, story, estimator),
  };
}

/** Means after the last change; of a run without one, at its end. */
export function afterLastChange(
  slide: Slide,
  story: Story | undefined,
  estimator: EstimatorShape,
): (number | null)[] {
  const times = story?.change_times_s ?? [];
  const atS = story?.changes.at(-1)?.at_s ?? times.at(-1) ?? null;
  const span = spanAround(atS, times, slide.end * slide.period);
  return beforeAfter(slide, estimator, span, undefined, undefined).map((row) =>
    atS === null ? row.before : row.after,
  );
}

/** A channel of several runs on one axis: time since the start, or since each run's fault. */
export function overlay(runs: ComparedRun[], channel: number, onFault: boolean): Aligned {
  const period = Math.min(...runs.map((run) => run.slide.period));
  const shift = (run: ComparedRun) => (onFault ? (run.onsetS ?? 0) : 0);
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

/** The value of each run at two times, NaN where there is none. */
export function valuesAt(data: Aligned, aS: number | null, bS: number | null): [number, number][] {
  const [first = 0, second = first + 1] = data.x;
  const at = (column: Float32Array, timeS: number | null) =>
    timeS === null
      ? Number.NaN
      : (column[Math.round((timeS - first) / (second - first))] ?? Number.NaN);
  return data.y.map((column) => [at(column, aS), at(column, bS)]);
}

/** What a plot shows between two times, as text: "t_s,run 1,run 2" and a line for each sample. */
export function overlayCsv(data: Aligned, labels: string[], fromS: number, toS: number): string {
  const quoted = labels.map((label) => `"${label.replaceAll('"', '""')}"`);
  const lines = [["t_s", ...quoted].join(",")];
  for (let at = 0; at < data.x.length; at++) {
    const t = data.x[at] as number;
    if (t < fromS || t > toS) continue;
    const values = data.y.map((column) => {
      const value = column[at] as number;
      return Number.isFinite(value) ? String(value) : "";
    });
    lines.push([Number(t.toFixed(6)), ...values].join(","));
  }
  return `${lines.join("\n")}\n`;
}
