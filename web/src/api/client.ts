import type { operations, paths } from "../../generated/api";
import type { Diagnosis, Page, Problem, Recording, Rig, Run } from "../contract/types";
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
export async function sendText<T>(path: string, body: string | Blob, type: string): Promise<T> {
  const headers = { "Content-Type": type };
  return parsed<T>(await request(path, { method: "POST", body, headers }));
}

async function parsed<T>(response: Response): Promise<T> {
  const text = await response.text();
  return (text ? JSON.parse(text) : {}) as T;
}

export const id = encodeURIComponent;

/** "?q=a&from=0"; an empty member asks nothing. */
export function queryOf(members: object): string {
  const query = new URLSearchParams();
  for (const [name, value] of Object.entries(members)) {
    if (value || value === 0) query.set(name, String(value));
  }
  return query.size > 0 ? `?${query}` : "";
}

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
export type UploadSettings = NonNullable<operations["uploadRecording"]["parameters"]["query"]>;

type Here = { [P in keyof paths as P extends `/api/v1${infer Path}` ? Path : never]: paths[P] };
type Verb = "get" | "post" | "put" | "patch" | "delete";
interface Operation {
  parameters: { path?: object; query?: object };
  requestBody?: object;
  responses: object;
}
/** Of the contract: "GET /rigs/{id}/health". */
export type Route = {
  [P in keyof Here]: {
    [V in Verb]: Here[P][V] extends Operation ? `${Uppercase<V>} ${P}` : never;
  }[Verb];
}[keyof Here];
type Of<R extends Route> = R extends `${infer V} ${infer P extends keyof Here}`
  ? Extract<Here[P][Lowercase<V> & Verb], Operation>
  : never;
type Some<T> = [Extract<T, object>] extends [never] ? Record<never, never> : Extract<T, object>;
type Json<T> = T extends { content: { "application/json": infer J } } ? J : never;
/** Members of the path and of the query; an empty one of the query asks nothing. */
type Names<O extends Operation, Q = Some<O["parameters"]["query"]>> = {
  [K in keyof Some<O["parameters"]["path"]>]: string | number;
} & { [K in keyof Q]: Q[K] | "" };
interface More<O extends Operation> {
  body?: Json<O["requestBody"]>;
  /** As last read: refused when somebody else has changed it since. */
  version?: number;
  signal?: AbortSignal;
}
type Given<O extends Operation> =
  Record<never, never> extends Names<O>
    ? [names?: Names<O>, more?: More<O>]
    : [names: Names<O>, more?: More<O>];
export type Answer<R extends Route, A = Of<R>["responses"]> = Json<A[keyof A & (200 | 201 | 202)]>;

export async function call<R extends Route>(
  route: R,
  ...[names, { body, version, signal } = {}]: Given<Of<R>>
): Promise<Answer<R>> {
  const query: Record<string, unknown> = { ...names };
  let [method, path] = route.split(" ") as ["POST", string];
  path = path.replace(/\{(\w+)\}/g, (_, name: string) => {
    const value = id(String(query[name]));
    delete query[name];
    return value;
  });
  path += queryOf(query);
  if (route.startsWith("GET ")) return get(path, signal);
  const headers = { "If-Match": `"${version}"` };
  return send(method, path, body, version === undefined ? {} : headers, signal);
}

export const api = {
  rigs: async () => (await get<Page<Rig>>("/rigs")).items,
  /** With `course` in the filter: the runs of the students of a course that the user teaches. */
  runs: (cursor?: string, limit = 30, filter: RunFilter = {}) =>
    get<Page<Run>>(`/runs${queryOf({ limit, cursor, ...filter })}`),
  run: (run: string) => call("GET /runs/{id}", { id: run }),
  /** Of a page that is closed: sent even after the page has gone. */
  abandonRun: (run: string) =>
    request(`/runs/${id(run)}/stop`, { method: "POST", keepalive: true }),
  diagnosis: (run: string) => get<Diagnosis>(`/runs/${id(run)}/diagnosis`),
  /** The binary frames of a recorded run, each preceded by its length (see stream/frame). */
  frames: (run: string, from = 0, signal?: AbortSignal) =>
    request(`/runs/${id(run)}/frames?from=${from}`, { signal }),
  uploadRecording: (csv: Blob, how: UploadSettings) =>
    sendText<Recording>(`/recordings${queryOf(how)}`, csv, csv.type),
};
