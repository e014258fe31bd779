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
  responses?: Record<
    string,
    { description?: string; $ref?: string; content?: Record<string, Content> }
  >;
  /** False: an API key, whatever its scopes, is refused. */
  "x-keys"?: boolean;
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
