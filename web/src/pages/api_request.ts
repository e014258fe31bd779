import type { Entry, Parameter } from "./openapi";

/** What the form of a route was filled with; values of parameters by their names. */
export interface Filled {
  values: Record<string, string>;
  body: string;
}

/** One HTTP request, ready to be sent or written down. */
export interface ApiRequest {
  method: string;
  url: string;
  /** Without the credentials. */
  headers: Record<string, string>;
  body: string;
  /** Where a program saves the answer; empty: it is text. */
  file: string;
}

/** The variable in which the copied programs look for an API key. */
export const KEY_VARIABLE = "FAULTLAB_KEY";

export function parametersOf(entry: Entry): Parameter[] {
  return entry.operation.parameters ?? [];
}

/** "application/json", "text/csv"; empty: the route takes no body. */
export function bodyType(entry: Entry): string {
  const types = Object.keys(entry.operation.requestBody?.content ?? {});
  return types.find((type) => type === "application/json") ?? types[0] ?? "";
}

/** The example of the description, as a person edits it. */
export function firstBody(entry: Entry): string {
  const type = bodyType(entry);
  const content = entry.operation.requestBody?.content?.[type];
  const example = content?.example ?? Object.values(content?.examples ?? {})[0]?.value;
  if (example === undefined) return type === "application/json" ? "{}" : "";
  return typeof example === "string" ? example : JSON.stringify(example, null, 2);
}

export function requestOf(entry: Entry, filled: Filled, origin: string): ApiRequest {
  let path = entry.path;
  const query = new URLSearchParams();
  const headers: Record<string, string> = {};
  for (const { name, in: where } of parametersOf(entry)) {
    const value = filled.values[name] ?? "";
    if (where === "path")
      path = path.replace(`{${name}}`, value ? encodeURIComponent(value) : name.toUpperCase());
    else if (value && where === "query") query.set(name, value);
    else if (value && where === "header") headers[name] = value;
  }
  const type = bodyType(entry);
  if (type) headers["Content-Type"] = type;
  const search = query.size > 0 ? `?${query}` : "";
  return {
    method: entry.method,
    url: origin + path + search,
    headers,
    body: type ? filled.body : "",
    file: answerFile(entry),
  };
}

const ENDINGS: Record<string, string> = {
  "image/png": "png",
  "image/jpeg": "jpg",
  "application/pdf": "pdf",
  "text/csv": "csv",
};

/** "report.pdf", "answer.mat"; empty for JSON and other short texts. */
export function answerFile(entry: Entry): string {
  const answers = Object.entries(entry.operation.responses ?? {});
  const types = answers.flatMap(([code, each]) =>
    code.startsWith("2") ? Object.keys(each.content ?? {}) : [],
  );
  const type = types.find((each) => !/json|^text\/(?!csv)|toml|yaml/.test(each));
  if (!type) return "";
  const last = entry.path.split("/").pop() ?? "";
  if (/^[\w-]+\.\w+$/.test(last)) return last;
  const ending = /\.(\w+)$/.exec(last)?.[1] ?? ENDINGS[type] ?? "bin";
  return `answer.${ending}`;
}

const quoted = (text: string) => `'${text.replaceAll("'", "'\\''")}'`;

/** A command for a shell. With `key` it reads the API key from KEY_VARIABLE. */
export function curlText(request: ApiRequest, key: boolean): string {
  const lines = [
    request.file
      ? `curl --fail --show-error --silent --output ${quoted(request.file)} --request ${request.method}`
      : `curl --include --show-error --silent --request ${request.method}`,
  ];
  if (key) lines.push(`--header "Authorization: Bearer $${KEY_VARIABLE}"`);
  for (const [name, value] of Object.entries(request.headers)) {
    lines.push(`--header ${quoted(`${name}: ${value}`)}`);
  }
  if (request.body) lines.push(`--data-binary ${quoted(request.body)}`);
  lines.push(quoted(request.url));
  return lines.join(" \\\n  ");
}

/** JSON text is a Python string, but for what Python reads otherwise: `\/` does not occur. */
const python = (text: string) => JSON.stringify(text);

/** A program for Python 3 alone. With `key` it reads the API key from KEY_VARIABLE. */
export function pythonText(request: ApiRequest, key: boolean): string {
  const lines = [
    ...(request.file ? [] : ["import json"]),
    ...(key ? ["import os"] : []),
    "import sys",
    "import urllib.error",
    "import urllib.request",
    "",
    "request = urllib.request.Request(",
    `    ${python(request.url)},`,
    `    method=${python(request.method)},`,
    ...(request.body ? [`    data=${python(request.body)}.encode(),`] : []),
    ")",
    ...Object.entries(request.headers).map(
      ([name, value]) => `request.add_header(${python(name)}, ${python(value)})`,
    ),
    ...(key
      ? [`request.add_header("Authorization", "Bearer " + os.environ[${python(KEY_VARIABLE)}])`]
      : []),
    "try:",
    "    answer = urllib.request.urlopen(request, timeout=30)",
    "except urllib.error.HTTPError as refusal:",
    '    sys.exit(f"{refusal.status} {refusal.read().decode()}")',
    "with answer:",
    "    content = answer.read()",
    ...(request.file
      ? [
          `    with open(${python(request.file)}, "wb") as file:`,
          "        file.write(content)",
          `    print(answer.status, len(content), "bytes in", ${python(request.file)})`,
        ]
      : [
          '    print(answer.status, answer.headers["Content-Type"])',
          '    if "json" in answer.headers.get("Content-Type", ""):',
          "        print(json.dumps(json.loads(content), indent=2, ensure_ascii=False))",
          "    else:",
          '        print(content.decode(errors="replace"))',
        ]),
  ];
  return `${lines.join("\n")}\n`;
}
