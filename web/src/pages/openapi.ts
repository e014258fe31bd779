/** The part of OpenAPI 3.1 that the reference page uses. */
export interface Parameter {
  name: string;
  in: string;
  required?: boolean;
  description?: string;
  schema?: { enum?: unknown[] };
  $ref?: string;
}
interface Content {
  example?: unknown;
  examples?: Record<string, { value?: unknown }>;
}
export interface Answer {
  description?: string;
  $ref?: string;
  content?: Record<string, Content>;
}
export interface Operation {
  summary?: string;
  description?: string;
  parameters?: Parameter[];
  requestBody?: { description?: string; content?: Record<string, Content> };
  responses?: Record<string, Answer>;
  /** Any of these lets one in; none is needed where it is empty. */
  security?: Record<string, string[]>[];
}
export interface OpenApi {
  paths: Record<string, Record<string, Operation>>;
  components?: {
    parameters?: Record<string, Parameter>;
    responses?: Record<string, Answer>;
  };
}

/** Whether an API key, with the right scopes, is let in; also where nothing is asked. */
export const takesKeys = ({ security = [] }: Operation): boolean =>
  security.length === 0 || security.some((way) => "key" in way || Object.keys(way).length === 0);

export interface Entry {
  method: string;
  path: string;
  operation: Operation;
}

const METHODS = ["get", "post", "put", "patch", "delete"];

/** What operations share by $ref stands in its place. */
export function entriesOf(description: OpenApi): Entry[] {
  const { parameters = {}, responses = {} } = description.components ?? {};
  const shared = <T extends { $ref?: string }>(each: T, all: Record<string, T>): T =>
    all[each.$ref?.split("/").pop() ?? ""] ?? each;
  return Object.entries(description.paths).flatMap(([path, item]) =>
    METHODS.filter((method) => item[method]).map((method) => {
      const own = item[method] as Operation;
      const operation: Operation = {
        ...own,
        parameters: own.parameters?.map((each) => shared(each, parameters)),
        responses: Object.fromEntries(
          Object.entries(own.responses ?? {}).map(([code, each]) => [
            code,
            shared(each, responses),
          ]),
        ),
      };
      return { method: method.toUpperCase(), path, operation };
    }),
  );
}
