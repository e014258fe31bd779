/**
 * An Error that a C++ source makes: `Refuse("reason", field, {{"name", value}})` with the sentence of
 * core/types/refusals.json, or `ErrorCode::kX, message, field, reason, {{"name", value}}`.
 */
export interface MadeError {
  where: string;
  /** Words that stand for the reason; empty if there is none or a variable has it. */
  reasons: string[];
  /** Whether anything stands in the reason's place. */
  given: boolean;
  parameters: string[];
}

/** The source without its comments. */
function plain(source: string): string {
  const parts = /R"(\w*)\([\s\S]*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<!\w)'(?:\\.|[^'\\\n])+'|\/\/[^\n]*/g;
  return source.replace(parts, (part) => (part.startsWith("//") ? "" : part));
}

/** What stands between the bracket at `open` and its end, split at its commas. */
function parts(source: string, open: number): string[] {
  const tokens = /"(?:\\.|[^"\\\n])*"|(?<!\w)'(?:\\.|[^'\\\n])+'|[([{]|[)\]}]|,/g;
  tokens.lastIndex = open;
  const found: string[] = [];
  let depth = 0;
  let start = open + 1;
  for (let token = tokens.exec(source); token; token = tokens.exec(source)) {
    if ("([{".includes(token[0])) depth++;
    if (")]}".includes(token[0])) depth--;
    if (depth === 0 || (depth === 1 && token[0] === ",")) {
      found.push(source.slice(start, token.index).trim());
      start = token.index + 1;
    }
    if (depth === 0) break;
  }
  return found;
}

const words = (text: string) =>
  [...text.matchAll(/"([a-z][a-z0-9_]*)"/g)].map(([, word]) => word as string);

const namesOf = (parameters = "") =>
  [...parameters.matchAll(/\{\s*"(\w+)"\s*,/g)].map(([, name]) => name as string);

export function errorsOf(path: string, text: string): MadeError[] {
  const source = plain(text);
  // A reader's own Refuse(..) has the name of the member first.
  const refused = [...source.matchAll(/\bRefuse\(/g)].flatMap((match) => {
    const given = parts(source, match.index + match[0].length - 1);
    const own = source[match.index - 1] === "." || words(given[0] ?? "").length === 0;
    const reasons = words(given[own ? 1 : 0] ?? "");
    if (reasons.length === 0) return [];
    return {
      where: `${path}: ${reasons}`,
      reasons,
      given: true,
      parameters: namesOf(given.at(-1)),
    };
  });
  const written = [...source.matchAll(/\{\s*(?:core::)?ErrorCode::k\w+\s*,/g)].flatMap((match) => {
    const given = parts(source, match.index);
    if (given.length < 2) return [];
    const reason = given[3] ?? "";
    return {
      where: `${path}: ${given[1]?.slice(0, 60)}`,
      reasons: words(reason),
      given: reason !== "" && reason !== "{}" && reason !== '""',
      parameters: namesOf(given[4]),
    };
  });
  return [...refused, ...written];
}
