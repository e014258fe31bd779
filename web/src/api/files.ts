// Addresses of what the server makes to be saved or shown by itself.
import { base, id } from "./client";

/** The description that a bench was made from, to start another one from. */
export const benchFileUrl = (bench: string) => `${base}/benches/${id(bench)}/file`;
export const exportUrl = (run: string, format: "csv" | "ipynb" | "mat" | "json" | "lcm") =>
  `${base}/runs/${id(run)}/export.${format}`;
export const estimatesUrl = (run: string) => `${exportUrl(run, "csv")}?content=estimates`;
const REPORT_LANGUAGES: Record<string, string> = { "sr-Latn": "sr", "sr-Cyrl": "sr-Cyrl" };
/** The report as PDF, in the language and script of the page. */
export const reportUrl = (run: string, locale: string) =>
  `${base}/runs/${id(run)}/report.pdf?language=${REPORT_LANGUAGES[locale] ?? "en"}`;
export const plotUrl = (run: string, figure: string, scale: 1 | 2) =>
  `${base}/runs/${id(run)}/plots/${figure}.png?scale=${scale}`;
/** `align`: what is drawn at 0. */
export const comparisonUrl = (runs: string[], estimator: string, align: "change" | "start") =>
  `${base}/comparison.png?runs=${runs.map(id).join(",")}&estimator=${estimator}&align=${align}&scale=2`;
/** Of a file of a run with hidden faults: the same with them, for its owner. */
export const withTruth = (url: string) => `${url}${url.includes("?") ? "&" : "?"}truth=include`;
export const sweepUrl = (batch: string, file = "sweep.png?scale=2") =>
  `${base}/jobs/batches/${id(batch)}/${file}`;
/** Whether and how each fault of a set is seen. */
export const isolabilityPng = (set: number, channels: string, samples: number) =>
  `${base}/fault-sets/${set}/isolability.png?channels=${channels}&window_samples=${samples}`;
/** The address at which a browser signs in at a provider and then goes on to `next`. */
export const signInUrl = (provider: string, next: string) =>
  `${base}/auth/oidc/${id(provider)}/start?next=${id(next)}`;
/** A line for each student, or for each trial; in the columns of a gradebook. */
export const gradesUrl = (assignment: number, query = "") =>
  `${base}/assignments/${assignment}/grades.csv${query}`;
