import type {
  Diagnosis,
  Me,
  Page,
  Problem,
  Recording,
  Rig,
  Run,
  RunControl,
  RunRequest,
  Schemas,
} from "../contract/types";
import { i18n, t } from "../i18n/i18n.svelte";
import { placeWords, refusalWords } from "../i18n/words";
import { busyDuring } from "../loading/busy";
import { answered, connection } from "../loading/connection.svelte";

/** A refusal by the server, with its message (RFC 9457). */
export class ApiError extends Error {
  constructor(
    readonly status: number,
    readonly problem: Partial<Problem>,
  ) {
    const message = problem.detail ?? problem.title ?? `HTTP ${status}`;
    super(placeWords(problem.field) + refusalWords({ ...problem, message }));
    this.name = "ApiError";
  }
}

/** The server did not answer: the link is cut, or the server restarts. */
export class NoAnswer extends Error {
  constructor() {
    super(t("server_away"));
    this.name = "NoAnswer";
  }
}

export const base = "/api/v1";
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

/**
 * Repeats a GET: when the server answers again, if it did not answer, and, if it has no capacity,
 * after the time that it states. What changes something is sent once.
 */
async function patiently(path: string, init: RequestInit): Promise<Response> {
  const read = !init.method || init.method === "GET";
  for (let tries = 1; ; tries++) {
    const response = await fetch(base + path, { credentials: "same-origin", ...init }).catch(
      (error: unknown) => {
        if (read && init.signal?.aborted) throw error;
        return null;
      },
    );
    if (!response || !answered(response)) {
      const back = connection.again();
      if (!read || tries === triesMax) throw new NoAnswer();
      const since = connection.outages;
      await back;
      if (connection.outages > since) tries = 0; // it was away, not only this address
      init.signal?.throwIfAborted();
      continue;
    }
    const wait = Number(response.headers.get("Retry-After") ?? Number.NaN);
    const full = response.status === 429 || response.status === 503;
    if (!full || !read || tries >= triesMax || !(wait <= 5)) return response;
    await new Promise((resume) => setTimeout(resume, wait * 1000));
  }
}

export async function request(path: string, init: RequestInit = {}): Promise<Response> {
  const headers = new Headers(init.headers);
  if (csrfToken && init.method && init.method !== "GET") headers.set("X-CSRF-Token", csrfToken);
  const response = await busyDuring(patiently(path, { ...init, headers }));
  if (response.ok) return response;
  if (response.status === 401) unauthorized();
  const text = await response.text();
  let problem: Partial<Problem> = { title: response.statusText };
  try {
    problem = JSON.parse(text) as Problem;
  } catch {
    if (text) problem.detail = text.slice(0, 300);
  }
  await i18n.loadAll().catch(() => {}); // without the texts it is said in the server's English
  throw new ApiError(response.status, problem);
}

/** With what it says read: until then the page is busy. */
export const get = <T>(path: string, signal?: AbortSignal): Promise<T> =>
  busyDuring(read<T>(path, signal));

async function read<T>(path: string, signal?: AbortSignal): Promise<T> {
  for (let tries = 1; ; tries++) {
    const response = await request(path, { signal });
    try {
      return (await response.json()) as T;
    } catch (error) {
      if (signal?.aborted || !(error instanceof TypeError)) throw error;
      if (tries === triesMax) throw new NoAnswer();
      await connection.again(); // the answer broke off
    }
  }
}

/** All pages of a list. @param path  without a query */
export async function getAll<T>(path: string): Promise<T[]> {
  const found: T[] = [];
  let cursor = "";
  do {
    const from = cursor && `&cursor=${encodeURIComponent(cursor)}`;
    const next = await get<Page<T>>(`${path}?limit=200${from}`);
    found.push(...next.items);
    cursor = next.next_cursor ?? "";
  } while (cursor);
  return found;
}

export async function send<T>(
  method: "POST" | "PUT" | "PATCH" | "DELETE",
  path: string,
  body?: unknown,
  headers: Record<string, string> = {},
  signal?: AbortSignal,
): Promise<T> {
  const init: RequestInit = { method, headers, signal };
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

export const id = encodeURIComponent;

/** What a list of runs shows; an empty member hides nothing. */
export interface RunFilter {
  q?: string;
  rig?: string;
  /** Experiments, unless it says otherwise. */
  source?: "upload" | "";
  verdict?: string;
  starred?: boolean;
  course?: number;
}

/** How a record is diagnosed: by default as usual on its bench, from its own healthy stretch. */
export interface UploadSettings {
  name: string;
  bench?: string;
  healthy_from_s?: number;
  healthy_to_s?: number;
  /** The id of a run or recording whose calibration is taken. */
  calibration?: string;
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
  /** Without an answer within `waitMs`: NoAnswer. Stopping twice does no harm. */
  stopRun: (run: string, waitMs: number) =>
    send<unknown>("POST", `/runs/${id(run)}/stop`, undefined, {}, AbortSignal.timeout(waitMs)),
  /** Of a page that is closed: sent even after the page has gone. */
  abandonRun: (run: string) =>
    request(`/runs/${id(run)}/stop`, { method: "POST", keepalive: true }),
  /** The run learns its healthy rig again, from now on. */
  learnAgain: (run: string) => send<unknown>("POST", `/runs/${id(run)}/calibration`),
  streamToken: (run: string) =>
    send<{ code: string; expires_in_s: number }>("POST", `/runs/${id(run)}/stream-token`),
  diagnosis: (run: string) => get<Diagnosis>(`/runs/${id(run)}/diagnosis`),
  control: (run: string, without: boolean) =>
    get<RunControl>(`/runs/${id(run)}/control${without ? "?without=include" : ""}`),
  figure: <T>(run: string, figure: string) => get<T>(`/runs/${id(run)}/figures/${figure}`),
  /** The binary frames of a recorded run, each preceded by its length (see stream/frame). */
  frames: (run: string, from = 0, signal?: AbortSignal) =>
    request(`/runs/${id(run)}/frames?from=${from}`, { signal }),

  usage: () => get<Schemas["Usage"]>("/usage"),
  uploadRecording: async (csv: Blob, how: UploadSettings) => {
    const query = new URLSearchParams();
    for (const [name, value] of Object.entries(how)) {
      if (value !== undefined && value !== "") query.set(name, String(value));
    }
    const response = await request(`/recordings?${query}`, {
      method: "POST",
      body: csv,
      headers: { "Content-Type": csv.type },
    });
    return (await response.json()) as Recording;
  },
};
