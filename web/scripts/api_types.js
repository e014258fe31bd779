// Writes generated/api.d.ts from the server's OpenAPI description, so that `npm run check` compares
// the page with the contract. Writes the file only when the contract has changed.
import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import openapiTS, { astToString } from "openapi-typescript";

const source = new URL("../../server/api/openapi.json", import.meta.url);
/** Each schema is a type of its own name, too. */
const named = { rootTypes: true, rootTypesNoSchemaPrefix: true, rootTypesKeepCasing: true };
const target = new URL("../generated/api.d.ts", import.meta.url);

const text = `// From server/api/openapi.json, by scripts/api_types.js.\n${astToString(await openapiTS(source, named))}`;
if (!existsSync(target) || readFileSync(target, "utf8") !== text) {
  mkdirSync(new URL(".", target), { recursive: true });
  writeFileSync(target, text);
}
