import { describe, expect, it } from "vitest";
import canvas from "../../server/plots/canvas.cc?raw";
import estimates from "../../server/plots/estimates_figure.cc?raw";
import marks from "../../server/plots/marks_painter.cc?raw";
import signals from "../../server/plots/signals_figure.cc?raw";
import { windowStyles } from "../src/live/window_styles";
import { darkInks, INK_OF, type Ink, lightInks } from "../src/theme/inks";
import { contrast, dark, light } from "../src/theme/tokens";

const hex = (bytes: string) =>
  `#${[...bytes.matchAll(/0x(..)/g)].map((match) => match[1]?.toLowerCase()).join("")}`;
const inkOf = (name: string) => name.toLowerCase() as Ink;

describe("page and PNG of the server", () => {
  it("draw each ink in the same colour", () => {
    const ofServer = Object.fromEntries(
      [...canvas.matchAll(/case Ink::k(\w+):\s+return \{(.*?)\};/g)].map(([, name, bytes]) => [
        inkOf(name as string),
        hex(bytes as string),
      ]),
    );
    expect(ofServer).toEqual(lightInks);
  });
  it.each(["uc", "um", "ua", "ia", "n"] as const)("draw %s in the same ink", (name) => {
    const member = name === "n" ? "n_rpm" : `${name}_${name === "ia" ? "a" : "v"}`;
    const drawn = new RegExp(`Sample::${member}[^;]*?Ink::k(\\w+)`).exec(signals)?.[1];
    expect(inkOf(drawn ?? "")).toBe(INK_OF[name]);
  });
  it("draw the windows of an estimator with the same inks and dashes", () => {
    const looks = [...estimates.matchAll(/\{Ink::k(\w+), Dash::k(\w+)\}/g)].slice(0, 3);
    expect(looks.map((look) => inkOf(look[1] ?? ""))).toEqual([
      INK_OF.short,
      INK_OF.medium,
      INK_OF.long,
    ]);
    expect(looks.map((look) => look[2])).toEqual(["Dotted", "Solid", "Dashed"]);
    const [short, medium, long] = windowStyles(light).map((style) => style.dash);
    expect(medium).toBeUndefined();
    expect(short?.[0]).toBeLessThan(long?.[0] ?? 0);
  });
  it("draw marks in the same colours", () => {
    const colour = (name: string) =>
      hex(new RegExp(`k${name}Colour = \\{(.*?)\\};`).exec(marks)?.[1] ?? "");
    expect([colour("Fault"), colour("Detect")]).toEqual([light.fault, light.detect]);
  });
});

describe("inks", () => {
  it.each([
    ["light", lightInks, light],
    ["dark", darkInks, dark],
  ])("stand out in the %s theme, and differ", (_, inks, tokens) => {
    for (const color of Object.values(inks)) {
      expect(contrast(color, tokens.surface), color).toBeGreaterThanOrEqual(3);
    }
    expect(new Set(Object.values(inks)).size).toBe(Object.keys(inks).length);
  });
});
