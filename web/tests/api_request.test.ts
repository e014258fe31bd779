import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { bodyType, curlText, firstBody, pythonText, requestOf } from "../src/pages/api_request";
import { type Entry, entriesOf, type OpenApi, takesKeys } from "../src/pages/openapi";

const description = JSON.parse(
  readFileSync(new URL("../../server/api/openapi.json", import.meta.url), "utf8"),
) as OpenApi;
const route = (method: string, path: string): Entry => {
  const found = entriesOf(description).find((each) => each.method === method && each.path === path);
  if (!found) throw new Error(`no ${method} ${path}`);
  return found;
};

describe("a request from the form of a route", () => {
  it("puts each value where its parameter stands", () => {
    const filled = { values: { id: "a b/c", scale: "2", figure: "swa" }, body: "" };
    const figure = route("GET", "/api/v1/runs/{id}/plots/{figure}.png");
    expect(requestOf(figure, filled, "http://host").url).toBe(
      "http://host/api/v1/runs/a%20b%2Fc/plots/swa.png?scale=2",
    );
    const change = route("PATCH", "/api/v1/users/{id}");
    const request = requestOf(
      change,
      { values: { id: "7", "If-Match": '"3"' }, body: '{"name":"N"}' },
      "http://host",
    );
    expect(request.headers).toEqual({ "If-Match": '"3"', "Content-Type": "application/json" });
    expect(request.body).toBe('{"name":"N"}');
  });
  it("starts with the description's example; CSV stays text", () => {
    expect(JSON.parse(firstBody(route("POST", "/api/v1/runs")))).toHaveProperty("duration_s");
    expect(bodyType(route("POST", "/api/v1/recordings"))).toBe("text/csv");
    expect(firstBody(route("GET", "/api/v1/runs"))).toBe("");
  });
  it("of a route that takes no body has none", () => {
    const filled = { values: {}, body: "left over" };
    const request = requestOf(route("GET", "/api/v1/rigs"), filled, "http://host");
    expect(request).toEqual({
      method: "GET",
      url: "http://host/api/v1/rigs",
      headers: {},
      body: "",
      file: "",
    });
  });
  it("names a parameter that is still empty, and the file of an answer that is not text", () => {
    const filled = { values: {}, body: "" };
    const report = requestOf(route("GET", "/api/v1/runs/{id}/report.pdf"), filled, "http://host");
    expect(report.url).toBe("http://host/api/v1/runs/ID/report.pdf");
    expect(report.file).toBe("report.pdf");
    expect(curlText(report, true)).toContain("--output 'report.pdf'");
    expect(curlText(report, true)).not.toContain("--include");
    expect(pythonText(report, true)).toContain('open("report.pdf", "wb")');
    expect(pythonText(report, true)).toContain("sys.exit(");
    const plot = route("GET", "/api/v1/runs/{id}/plots/{figure}.png");
    expect(requestOf(plot, filled, "").file).toBe("answer.png");
  });
  it("says of which routes keys are refused", () => {
    expect(takesKeys({ security: [{ session: [], csrf: [] }] })).toBe(false);
    expect(takesKeys({ security: [{ key: ["jobs"] }, { session: [] }] })).toBe(true);
    expect(takesKeys({ security: [{}, { session: [] }] })).toBe(true);
    expect(takesKeys({ security: [] })).toBe(true);
  });
});

describe("a program to copy", () => {
  const request = {
    method: "POST",
    url: "http://host/api/v1/rigs/x/quarantine",
    headers: { "Content-Type": "application/json" },
    body: `{"reason":"it's \\"hot\\" $HOME \`id\`"}`,
    file: "",
  };
  it("for a shell expands nothing but the key", () => {
    const text = curlText(request, true);
    expect(text).toContain('"Authorization: Bearer $FAULTLAB_KEY"');
    expect(text).toContain("'{\"reason\":\"it'\\''s");
    expect(curlText(request, false)).not.toContain("FAULTLAB_KEY");
  });
  it("for Python keeps the body character by character", () => {
    const line = pythonText(request, true)
      .split("\n")
      .find((each) => each.includes("data="));
    expect(JSON.parse(/data=(".*")\.encode/.exec(line ?? "")?.[1] ?? "")).toBe(request.body);
  });
});
