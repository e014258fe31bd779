import { describe, expect, it } from "vitest";
import { contrast, dark, light, type Tokens } from "../src/theme/tokens";

const TEXT: (keyof Tokens)[] = [
  "text",
  "muted",
  "accent",
  "good",
  "warn",
  "danger",
  "fault",
  "detect",
];
const LINES: (keyof Tokens)[] = [
  "uc",
  "um",
  "ua",
  "ia",
  "n",
  "short",
  "medium",
  "long",
  "nominal",
  "fault",
  "detect",
  "control",
];

describe.each([
  ["light", light],
  ["dark", dark],
])("%s theme", (_, tokens) => {
  it.each(TEXT)("text in %s reads on every surface", (name) => {
    for (const surface of [tokens.page, tokens.surface, tokens.raised]) {
      expect(contrast(tokens[name], surface)).toBeGreaterThanOrEqual(4.5);
    }
  });
  it.each(LINES)("lines in %s stand out from the chart", (name) => {
    expect(contrast(tokens[name], tokens.surface)).toBeGreaterThanOrEqual(3);
  });
  it("labels on buttons read", () => {
    expect(contrast(tokens.onAccent, tokens.accent)).toBeGreaterThanOrEqual(4.5);
    expect(contrast(tokens.onDanger, tokens.danger)).toBeGreaterThanOrEqual(4.5);
  });
});
