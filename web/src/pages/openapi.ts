/** The part of OpenAPI 3.1 that the reference page uses. */
export interface Schema {
  type?: string | string[];
  description?: string;
  enum?: unknown[];
  properties?: Record<string, Schema>;
  required?: string[];
  items?: Schema;
  $ref?: string;
  oneOf?: Schema[];
  default?: unknown;
}
export interface Parameter {
  name: string;
  in: string;
  required?: boolean;
  description?: string;
  schema?: Schema;
  $ref?: string;
}
interface Content {
  schema?: Schema;
  example?: unknown;
  examples?: Record<string, { value?: unknown }>;
}
export interface Operation {
  summary?: string;
  description?: string;
  tags?: string[];
  operationId?: string;
  parameters?: Parameter[];
  requestBody?: { description?: string; content?: Record<string, Content> };
  responses?: Record<string, { description?: string; $ref?: string }>;
}
export interface OpenApi {
  info: { title: string; version: string };
  paths: Record<string, Record<string, Operation>>;
  components?: {
    parameters?: Record<string, Parameter>;
    responses?: Record<string, { description?: string }>;
  };
}

export interface Entry {
  method: string;
  path: string;
  operation: Operation;
  tag: string;
}

const METHODS = ["get", "post", "put", "patch", "delete"];

export function entriesOf(description: OpenApi): Entry[] {
  return Object.entries(description.paths).flatMap(([path, item]) =>
    METHODS.filter((method) => item[method]).map((method) => {
      const operation = item[method] as Operation;
      return { method: method.toUpperCase(), path, operation, tag: operation.tags?.[0] ?? "" };
    }),
  );
}

export function resolveParameter(description: OpenApi, parameter: Parameter): Parameter {
  const name = parameter.$ref?.split("/").pop();
  return (name && description.components?.parameters?.[name]) || parameter;
}

export function answerText(description: OpenApi, answer: { description?: string; $ref?: string }) {
  const name = answer.$ref?.split("/").pop();
  return (
    (name && description.components?.responses?.[name]?.description) ?? answer.description ?? ""
  );
}

/** An example body from the description, as JSON text. */
export function exampleOf(operation: Operation): string {
  const content = operation.requestBody?.content?.["application/json"];
  const example = content?.example ?? Object.values(content?.examples ?? {})[0]?.value;
  return example === undefined ? "" : JSON.stringify(example);
}

export function curlOf(entry: Entry, origin: string): string {
  const example = exampleOf(entry.operation);
  const method = entry.method === "GET" ? "" : `-X ${entry.method} `;
  const body = example ? ` -H 'Content-Type: application/json' -d '${example}'` : "";
  return `curl ${method}${origin}${entry.path}${body}`;
}
