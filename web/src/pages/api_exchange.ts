import type { ApiRequest } from "./api_request";

/** Headers that tell something about an answer, in the order in which they are shown. */
const SHOWN = [
  "Content-Type",
  "Content-Disposition",
  "ETag",
  "Location",
  "Retry-After",
  "Idempotency-Replayed",
];
const TEXT_MAX = 20_000;

export interface Answer {
  status: number;
  statusText: string;
  milliseconds: number;
  bytes: number;
  headers: [string, string][];
  /** JSON with indents, or text, both cut; empty for other types. */
  text: string;
  cut: boolean;
  /** An answer that is not text; its type is that of the answer. */
  binary?: Blob;
}

/**
 * Sends with the page's own sign-in, or with `key` alone.
 * @param csrf  of the sign-in, which a request that changes something needs
 */
export async function exchange(request: ApiRequest, key: string, csrf: string): Promise<Answer> {
  const headers = new Headers(request.headers);
  if (key) headers.set("Authorization", `Bearer ${key}`);
  else if (csrf && request.method !== "GET") headers.set("X-CSRF-Token", csrf);
  const begun = performance.now();
  const response = await fetch(request.url, {
    method: request.method,
    headers,
    body: request.body || undefined,
    credentials: key ? "omit" : "same-origin",
    redirect: "manual",
  });
  const bytes = await response.arrayBuffer();
  const type = response.headers.get("Content-Type") ?? "";
  const text = readable(type, bytes);
  return {
    status: response.status,
    statusText: response.statusText,
    milliseconds: Math.round(performance.now() - begun),
    bytes: bytes.byteLength,
    headers: SHOWN.flatMap((name): [string, string][] => {
      const value = response.headers.get(name);
      return value === null ? [] : [[name, value]];
    }),
    text: text.slice(0, TEXT_MAX),
    cut: text.length > TEXT_MAX,
    binary: text || bytes.byteLength === 0 ? undefined : new Blob([bytes], { type }),
  };
}

function readable(type: string, bytes: ArrayBuffer): string {
  if (/json/.test(type)) {
    const text = new TextDecoder().decode(bytes);
    try {
      return JSON.stringify(JSON.parse(text), null, 2);
    } catch {
      return text;
    }
  }
  return /^text\/|toml/.test(type) ? new TextDecoder().decode(bytes) : "";
}
