import { refusalWords } from "../i18n/words";
import type {
  Diagnosis,
  Me,
  Page,
  Problem,
  Recording,
  Rig,
  Run,
  RunRequest,
  Schemas,
} from "./types";

/** A refusal by the server, with its message (RFC 9457). */
export class ApiError extends Error {
  constructor(
    readonly status: number,
    readonly problem: Partial<Problem>,
  ) {
    const message = problem.detail ?? problem.title ?? `HTTP ${status}`;
    super(refusalWords({ ...problem, message }));
    this.name = "ApiError";
  }
}

const base = "/api/v1";
let csrfToken = "";

/** Sets the token that is sent with every request that changes something, after the sign-in. */
export function useCsrfToken(token: string): void {
  csrfToken = token;
}

let unauthorized = () => {};

/** Sets a handler that is called when the server no longer accepts the sign-in. */
export function onUnauthorized(handler: () => void): void {
  unauthorized = handler;
}

const triesMax = 4;

/** Repeats a GET for which the server has no capacity, after the time that the server states. */
async function patiently(path: string, init: RequestInit): Promise<Response> {
  for (let tries = 1; ; tries++) {
    const response = await fetch(base + path, { credentials: "same-origin", ...init });
    const wait = Number(response.headers.get("Retry-After") ?? Number.NaN);
    const read = !init.method || init.method === "GET";
    if (response.status !== 429 || !read || tries === triesMax || !(wait <= 5)) return response;
    await new Promise((resume) => setTimeout(resume, wait * 1000));
  }
}

export async function request(path: string, init: RequestInit = {}): Promise<Response> {
  const headers = new Headers(init.headers);
  if (csrfToken && init.method && init.method !== "GET") headers.set("X-CSRF-Token", csrfToken);
  const response = await patiently(path, { ...init, headers });
  if (response.ok) return response;
  if (response.status === 401) unauthorized();
  const text = await response.text();
  let problem: Partial<Problem> = { title: response.statusText };
  try {
    problem = JSON.parse(text) as Problem;
  } catch {
    if (text) problem.detail = text.slice(0, 300);
  }
  throw new ApiError(response.status, problem);
}

export async function get<T>(path: string, signal?: AbortSignal): Promise<T> {
  return (await request(path, { signal })).json() as Promise<T>;
}

export async function send<T>(
  method: "POST" | "PUT" | "PATCH" | "DELETE",
  path: string,
  body?: unknown,
  headers: Record<string, string> = {},
): Promise<T> {
  const init: RequestInit = { method, headers };
  if (body !== undefined) {
    init.body = JSON.stringify(body);
    init.headers = { "Content-Type": "application/json", ...headers };
  }
  return parsed<T>(await request(path, init));
}

/** Sends a body that is not JSON. */
export async function sendText<T>(
  method: "POST" | "PUT",
  path: string,
  body: string,
  type: string,
): Promise<T> {
  return parsed<T>(await request(path, { method, body, headers: { "Content-Type": type } }));
}

async function parsed<T>(response: Response): Promise<T> {
  const text = await response.text();
  return (text ? JSON.parse(text) : {}) as T;
}

const id = encodeURIComponent;

/** What a list of runs shows; an empty member hides nothing. */
export interface RunFilter {
  q?: string;
  rig?: string;
  verdict?: string;
  starred?: boolean;
  course?: number;
}

export const api = {
  me: () => get<Me>("/auth/me"),
  login: (login: string, password: string) => send<Me>("POST", "/auth/login", { login, password }),
  logout: () => send<unknown>("POST", "/auth/logout", {}),
  rigs: async () => (await get<Page<Rig>>("/rigs")).items,
  benches: async () => (await get<Schemas["BenchList"]>("/benches")).items,
  bench: (bench: string) => get<Schemas["Bench"]>(`/benches/${id(bench)}`),
  /** The bench's model: nominal, or with one component changed. */
  model: (bench: string, query: string) =>
    get<Schemas["BenchModel"]>(`/benches/${id(bench)}/model?${query}`),
  rigClasses: async () => (await get<Page<Schemas["RigClass"]>>("/rig-classes")).items,

  startRun: (plan: RunRequest) => send<Run>("POST", "/runs", plan),
  /** With `course` in the filter: the runs of the students of a course that the user teaches. */
  runs: (cursor?: string, limit = 30, filter: RunFilter = {}) => {
    const query = new URLSearchParams({ limit: String(limit) });
    for (const [name, value] of Object.entries({ cursor, ...filter })) {
      if (value) query.set(name, String(value));
    }
    return get<Page<Run>>(`/runs?${query}`);
  },
  /** Name and note of one's own run; a star of one's own on any. */
  describeRun: (run: string, what: { name?: string; note?: string; starred?: boolean }) =>
    send<Schemas["RunDescription"]>("PATCH", `/runs/${id(run)}`, what),
  run: (run: string) => get<Run>(`/runs/${id(run)}`),
  deleteRun: (run: string) => send<unknown>("DELETE", `/runs/${id(run)}`),
  stopRun: (run: string) => send<unknown>("POST", `/runs/${id(run)}/stop`),
  /** The run learns its healthy rig again, from now on. */
  learnAgain: (run: string) => send<unknown>("POST", `/runs/${id(run)}/calibration`),
  streamToken: (run: string) =>
    send<{ code: string; expires_in_s: number }>("POST", `/runs/${id(run)}/stream-token`),
  diagnosis: (run: string) => get<Diagnosis>(`/runs/${id(run)}/diagnosis`),
  figure: <T>(run: string, figure: string) => get<T>(`/runs/${id(run)}/figures/${figure}`),
  /** The binary frames of a recorded run, each preceded by its length (see stream/frame). */
  frames: (run: string, from = 0, signal?: AbortSignal) =>
    request(`/runs/${id(run)}/frames?from=${from}`, { signal }),

  usage: () => get<Schemas["Usage"]>("/usage"),
  recordings: async () => (await get<Page<Recording>>("/recordings")).items,
  uploadRecording: async (csv: Blob, name: string, bench: string | undefined) => {
    const of = bench ? `&bench=${id(bench)}` : "";
    const response = await request(`/recordings?name=${id(name)}${of}`, {
      method: "POST",
      body: csv,
      headers: { "Content-Type": csv.type },
    });
    return (await response.json()) as Recording;
  },
};

/** The description that a bench was made from, to start another one from. */
export const benchFileUrl = (bench: string) => `${base}/benches/${id(bench)}/file`;
export const exportUrl = (run: string, format: "csv" | "mat" | "json") =>
  `${base}/runs/${id(run)}/export.${format}`;
export const estimatesUrl = (run: string) => `${exportUrl(run, "csv")}?content=estimates`;
/** The report as PDF; Serbian is in Latin script. */
export const reportUrl = (run: string, locale: string) =>
  `${base}/runs/${id(run)}/report.pdf?language=${locale === "en" ? "en" : "sr"}`;
export const plotUrl = (run: string, figure: string, scale: 1 | 2) =>
  `${base}/runs/${id(run)}/plots/${figure}.png?scale=${scale}`;
