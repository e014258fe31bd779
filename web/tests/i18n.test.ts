import { describe, expect, it } from "vitest";
import stretchChecks from "../../core/calibration/stretch_checks.cc?raw";
import contract from "../../server/api/openapi.json";
import authReadme from "../../server/auth/README.md?raw";
import runReadme from "../../server/run/README.md?raw";
import { ApiError } from "../src/api/client";
import { toCyrillic } from "../src/i18n/cyrillic";
import { en as first } from "../src/i18n/en";
import { enMore } from "../src/i18n/en_more";
import { fill, loadCatalogue } from "../src/i18n/i18n.svelte";
import { refusalsSr } from "../src/i18n/refusals_sr";
import { srLatn } from "../src/i18n/sr_latn";
import { detailWords, learningWords, placeWords, refusalWords } from "../src/i18n/words";

const refusalsOfTheServer = [runReadme, authReadme]
  .map(
    (readme) => /\*\*Refusals\.\*\*[\s\S]*?`parameters`.*?: ([\s\S]*?\.)\s/.exec(readme)?.[1] ?? "",
  )
  .join("\n");
const places = (text: string) => [...text.matchAll(/\{(\w+)\}/g)].map((match) => match[1]).sort();
const en = { ...first, ...enMore };
const keys = Object.keys(en) as (keyof typeof en)[];

describe("catalogues", () => {
  it("have the same keys", () => {
    expect(Object.keys(srLatn).sort()).toEqual([...keys].sort());
  });
  it.each(["sr-Latn", "sr-Cyrl"] as const)(
    "%s says everything, with the same places",
    async (locale) => {
      const catalogue = await loadCatalogue(locale);
      for (const key of keys) {
        expect(catalogue[key].trim(), key).not.toBe("");
        expect(places(catalogue[key]), key).toEqual(places(en[key]));
        expect(catalogue[key], key).not.toContain("`");
      }
    },
  );
  it("leave no Serbian word in Latin letters when Cyrillic is chosen", async () => {
    const catalogue = await loadCatalogue("sr-Cyrl");
    for (const key of keys) {
      const kept = catalogue[key].replace(/\{\w+\}/g, "");
      expect(kept, key).not.toMatch(/[čćžšđČĆŽŠĐ]/);
      // a Latin letter beside a Cyrillic one would be a half-converted word
      expect(kept, key).not.toMatch(/[a-z][а-шђјљњћџ]|[а-шђјљњћџ][a-z]/i);
    }
  });
  it("keep names and formats in Latin", () => {
    expect(toCyrillic("Preuzmi CSV, SWA procene, {component} i b0d")).toBe(
      "Преузми CSV, SWA процене, {component} и b0d",
    );
    expect(toCyrillic("Ljubljana, džep, Njegoš {value}")).toBe("Љубљана, џеп, Његош {value}");
  });
  it("fill their places", () => {
    expect(fill("{a} of {b}", { a: 1 })).toBe("1 of {b}");
  });
});

describe("refusals", () => {
  /** `rig_elsewhere` (rig, member) in the server's list. */
  const listed = new Map(
    [...refusalsOfTheServer.matchAll(/`([a-z_]+)`(?:\s+\(([\w,\s]+)\))?[,.]/g)].map(
      ([, reason, names]) => [reason as string, names?.split(/,\s+/) ?? []],
    ),
  );
  it("of the server have a sentence each, with its names and numbers", () => {
    expect(listed.size).toBeGreaterThan(10);
    for (const [reason, names] of listed) {
      const sentence = refusalsSr[`refused_${reason}`] ?? "";
      expect(sentence, reason).not.toBe("");
      for (const place of places(sentence)) expect(names, reason).toContain(place);
    }
    expect(Object.keys(refusalsSr)).toHaveLength(listed.size);
  });
  it("are said in the reader's language, else in the server's words", async () => {
    const refusal = {
      message: "This rig needs a session.",
      reason: "rig_needs_session",
      parameters: { rig: "bench-1" },
    };
    expect(refusalWords(refusal)).toBe(refusal.message);
    expect(new ApiError(403, { detail: "No.", reason: "news" }).message).toBe("No.");
    const catalogue: Record<string, string> = await loadCatalogue("sr-Cyrl");
    expect(fill(catalogue.refused_rig_needs_session ?? "", refusal.parameters)).toBe(
      "За уређај bench-1 потребан је термин: станите у ред или га резервишите.",
    );
  });
});

describe("texts of the server that the page does not show as they are", () => {
  const server = import.meta.glob("../../server/**/*.cc", {
    query: "?raw",
    import: "default",
    eager: true,
  }) as Record<string, string>;
  const sources = Object.values(server).join("\n");
  const all = (form: RegExp, text = sources) => [
    ...new Set([...text.matchAll(form)].map((match) => match[1] as string)),
  ];

  it("every reason of a refusal of runs and of a sent member has a sentence", () => {
    const files = ["../../server/run/refusals.cc", "../../server/json/json_reader.cc"];
    const reasons = files.flatMap((file) =>
      all(/(?<![{"\w])"([a-z]+(?:_[a-z]+)+)"(?:,\s*\{\{|\};)/g, server[file] ?? ""),
    );
    expect(reasons.length).toBeGreaterThan(30);
    expect(reasons.filter((reason) => !refusalsSr[`refused_${reason}`])).toEqual([]);
  });
  it("every verb of the audit log is said in the reader's language", () => {
    const verbs = [
      ...all(/audit\.Add(?:Bounded)?\(\s*\{?[\w.() ]+,\s*"([a-z_]+)"/g),
      ...all(/AuditNote\s+\w+\{\s*[\w.() ]+,\s*"([a-z_]+)"/g),
      ...all(/note\("([a-z_]+)"\)/g),
      ...all(/'system', '([a-z_]+)'/g),
    ];
    expect(verbs.length).toBeGreaterThan(20);
    expect(verbs.filter((verb) => !keys.some((key) => key === `audit_${verb}`))).toEqual([]);
  });
  it("every check of the healthy beginning has a sentence", () => {
    const checks = all(/Judge\(\s*checks,\s*"([a-z]+)"/g, stretchChecks);
    expect(checks.length).toBeGreaterThan(6);
    expect(checks.filter((check) => !keys.some((key) => key === `check_${check}`))).toEqual([]);
    const unknown = "not calibrated, check 'other' failed: 1 V";
    expect(learningWords(unknown)).toBe(unknown);
  });
  it("the detail of a line of the log is told member by member", () => {
    expect(detailWords('{"disabled":true,"new_name":"Vera"}')).toBe(
      "disabled: true, new name: Vera",
    );
    expect(detailWords("from 10.0.0.1")).toBe("from 10.0.0.1");
    expect(detailWords("{broken")).toBe("{broken");
  });
  it("a refused fault is named by its place, not by a pointer", () => {
    expect(placeWords("/faults/1/at_s")).toBe("Fault 2: ");
    expect(placeWords("/rig")).toBe("");
    expect(placeWords(undefined)).toBe("");
  });
});

describe("words of the contract", () => {
  const { schemas } = contract.components;
  it.each([
    ["state", schemas.Run.properties.state.enum],
    ["state", schemas.Job.properties.state.enum],
    ["state", schemas.Session.properties.state.enum],
    ["rig", schemas.Rig.properties.state.enum],
    ["rig", schemas.LabRig.properties.status.enum],
    ["verdict", schemas.Diagnosis.properties.verdict.enum],
    ["booking", schemas.Booking.properties.state.enum],
    ["role", schemas.User.properties.role.enum],
  ])("every %s is said in the reader's language", (group, values) => {
    expect(values.filter((value) => !keys.some((key) => key === `${group}_${value}`))).toEqual([]);
  });
});

describe("keys", () => {
  it("stand in one of the two English parts only", () => {
    expect(Object.keys(first).filter((key) => key in enMore)).toEqual([]);
  });
  it("are all used by the page", () => {
    const sources = import.meta.glob("../src/**/*.{svelte,ts}", {
      query: "?raw",
      import: "default",
      eager: true,
    }) as Record<string, string>;
    const text = Object.entries(sources)
      .filter(([path]) => !path.includes("/i18n/"))
      .map(([, source]) => source)
      .join("\n");
    const groups = [...text.matchAll(/\bword\("(\w+)"/g)].map((match) => `${match[1]}_`);
    groups.push("news_"); // by topic of a lab event
    groups.push("audit_", "check_"); // by verb of the audit log, by check of the calibration
    groups.push("failed_oidc_"); // by the word of a refused sign-in
    const topics = [...text.matchAll(/"(\w+)"/g)].map((match) => match[1]);
    const used = (key: string) =>
      text.includes(`"${key}"`) ||
      groups.some((group) => key.startsWith(group)) ||
      topics.some((topic) => key === `help_${topic}` || key === `help_${topic}_text`);
    expect(keys.filter((key) => !used(key))).toEqual([]);
  });
});
