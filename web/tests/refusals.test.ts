import { describe, expect, it } from "vitest";
import contract from "../../server/api/openapi.json";
import { ApiError } from "../src/api/client";
import type { Key, Text } from "../src/i18n/catalogue";
import { i18n, LOCALES, loadCatalogue } from "../src/i18n/i18n.svelte";
import { texts as en } from "../src/i18n/languages/en";
import { placeWords, refusalWords } from "../src/i18n/words";
import { errorsOf } from "./support/cpp_errors";

const { enum: reasons, "x-parameters": parametersOf } = contract.components.schemas.RefusalReason;
const parameters = new Map<string, string[]>(Object.entries(parametersOf));
const sources = import.meta.glob(
  [
    "../../server/**/*.cc",
    "../../server/**/*.h",
    "../../core/**/*.cc",
    "../../hardware/**/*.cc",
    "../../core/types/result.h",
  ],
  {
    query: "?raw",
    import: "default",
    eager: true,
  },
) as Record<string, string>;
/** What nobody sees on the page: the start of a program and its command line. */
const UNSEEN =
  /\/server\/(cli|app|lti|oidc|web_client)\/|\/server\/config|\/server\/net\/(http_server|listen_address|trusted_proxies)|\/server\/storage\/(database|database_check|folder_lock|migrations|postgres_location)\.cc|\/server\/plots\/render|\/hardware\/(config|device|comedi|lcm|bench)\/|\/core\/(estimators|paper|diagnosis|calibration)\/|\/core\/signals\/excitation_text/;
const seen = Object.entries(sources).filter(([path]) => !UNSEEN.test(path));
const made = seen.flatMap(([path, source]) => errorsOf(path, source));
/** Also the core::Refuse(..) of what nobody sees on the page. */
const all = Object.entries(sources).flatMap(([path, source]) =>
  errorsOf(
    path,
    UNSEEN.test(path) ? source.replace(/(?<!core::)\bRefuse\(|ErrorCode::/g, "other(") : source,
  ),
);
const places = (text: Text | undefined) =>
  [
    ...(typeof text === "string" ? text : Object.values(text ?? {}).join()).matchAll(/\{(\w+)\}/g),
  ].map(([, name]) => name as string);

describe("refusals of the server", () => {
  it("all have a reason", () => {
    expect(made.length).toBeGreaterThan(200);
    expect(made.filter((error) => !error.given).map((error) => error.where)).toEqual([]);
  });
  it("have reasons and parameters of the contract", () => {
    for (const error of all) {
      for (const reason of error.reasons) {
        if (/^(oidc|lti)_/.test(reason)) continue; // said in the page's address, failed_oidc_.., or in the page of a frame
        expect(reasons, error.where).toContain(reason);
        for (const name of parameters.get(reason) ?? []) {
          expect(error.parameters, `${error.where}: ${reason}`).toContain(name);
        }
      }
    }
  });
  it("are all made somewhere", () => {
    const text = Object.values(sources).join("\n");
    expect(reasons.filter((reason) => !text.includes(`"${reason}"`))).toEqual([]);
  });
  it.each(LOCALES)(
    "have a sentence each in $locale, with the parameters that come",
    async ({ locale }) => {
      const catalogue = await loadCatalogue(locale);
      for (const reason of reasons) {
        const said = catalogue[`refused_${reason}` as Key];
        expect(said, reason).toBeTruthy();
        for (const place of places(said))
          expect(parameters.get(reason) ?? [], reason).toContain(place);
      }
    },
  );
  it("leave no sentence over", () => {
    const said = Object.keys(en).flatMap((key) => /^refused_(.*)$/.exec(key)?.[1] ?? []);
    expect(said.filter((reason) => !reasons.includes(reason))).toEqual([]);
  });
  it("a source without a reason is found", () => {
    const bare = 'return core::Error{core::ErrorCode::kInvalid, "no (way), {x}", "/rig"};';
    const whole = 'return {ErrorCode::kBusy, "is, in use", "", "rig_in_use", {{"rig", rig}}};';
    expect(errorsOf("a", bare)).toMatchObject([{ given: false, reasons: [] }]);
    expect(errorsOf("a", whole)).toMatchObject([
      { given: true, reasons: ["rig_in_use"], parameters: ["rig"] },
    ]);
  });
});

describe("what the page says of a refusal", () => {
  const sign = async (locale: string) => (locale === "en" ? i18n.loadAll() : i18n.set(locale));
  Object.assign(globalThis, {
    localStorage: { setItem: () => {}, getItem: () => null },
    document: { documentElement: {} },
  });
  const busy = { message: "It is.", reason: "rig_needs_session", parameters: { rig: "bench-1" } };

  it("is its own sentence", async () => {
    await sign("en");
    expect(refusalWords(busy)).toBe("bench-1 needs a session: join its queue or book it.");
    expect(new ApiError(403, { detail: "No." }).message).toBe("No.");
  });
  it("names fields and values as people write them", async () => {
    const member = { message: "", reason: "member_missing", parameters: { member: "duration_s" } };
    expect(refusalWords(member)).toBe("The duration is missing.");
    const relays = { component: "R12", values: "1500, 5600", unit: "ohm" };
    expect(
      refusalWords({ message: "", reason: "value_not_of_the_relays", parameters: relays }),
    ).toBe("The relays of R12 have the values 1.5 kΩ, 5.6 kΩ.");
    const state = { message: "", reason: "not_ready", parameters: { state: "quarantined" } };
    expect(refusalWords(state)).toContain("quarantined");
    const late = { detail: "", reason: "fault_outside_run", field: "/faults/1/at_s" } as const;
    expect(new ApiError(400, late).message).toBe("Fault 2: The fault must begin within the run.");
    expect(placeWords("/rig")).toBe("");
    expect(placeWords(undefined)).toBe("");
  });
  it("is said in the reader's language, with its plural and its numbers", async () => {
    await sign("sr-Cyrl");
    expect(refusalWords(busy)).toBe(
      "За уређај bench-1 потребна је сесија: станите у ред или га закажите.",
    );
    await sign("sr-Latn");
    const longest = { message: "", reason: "replay_too_long", parameters: { longest_s: "12.5" } };
    expect(refusalWords(longest)).toContain("12,5 s");
    const quota = {
      message: "",
      reason: "quota_full",
      parameters: { kept: "12000", most: "20000" },
    };
    expect(refusalWords(quota)).toContain("12.000 od 20.000");
  });
});
