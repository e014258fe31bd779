import { describe, expect, it } from "vitest";
import stretchChecks from "../../core/calibration/stretch_checks.cc?raw";
import contract from "../../server/api/openapi.json";
import auditVerbs from "../../server/auth/audit_verbs.h?raw";
import type { Key, Text } from "../src/i18n/catalogue";
import { fill, formOf, LOCALES, loadCatalogue } from "../src/i18n/i18n.svelte";
import { auditLine, detailWords, objectWords } from "../src/i18n/lab_words";
import { texts as en } from "../src/i18n/languages/en";
import { texts as first } from "../src/i18n/languages/en.ts?first";
import { texts as lessons } from "../src/i18n/languages/en.ts?lessons";
import { texts as rest } from "../src/i18n/languages/en.ts?rest";
import { rigWords } from "../src/i18n/rig_words";
import { toCyrillic } from "../src/i18n/serbian_scripts";

const forms = (text: Text | undefined): string[] =>
  typeof text === "object" ? Object.values(text) : [text ?? ""];
const places = (text: Text | undefined) =>
  [
    ...new Set(forms(text).flatMap((form) => [...form.matchAll(/\{(\w+)\}/g)].map((m) => m[1]))),
  ].sort();
const keys = Object.keys(en) as Key[];
const others = LOCALES.map(({ locale }) => locale).filter((locale) => locale !== "en");

describe("catalogues", () => {
  it("are one file each, named by the language", () => {
    expect(LOCALES.map(({ locale }) => locale)).toEqual(["en", "sr-Latn", "sr-Cyrl"]);
    expect(LOCALES.map(({ name }) => name)).toEqual(["English", "Srpski", "Српски"]);
  });
  it.each(others)("%s says everything, with the same places", async (locale) => {
    const catalogue = await loadCatalogue(locale);
    expect(Object.keys(catalogue).sort()).toEqual([...keys].sort());
    for (const key of keys) {
      expect(places(catalogue[key]), key).toEqual(places(en[key]));
      for (const form of forms(catalogue[key])) {
        expect(form.trim(), key).not.toBe("");
        expect(form, key).not.toContain("`");
      }
    }
  });
  it.each(LOCALES)("$locale has each plural form that its numbers need", async ({ locale }) => {
    const needed = new Intl.PluralRules(locale).resolvedOptions().pluralCategories.sort();
    for (const [key, text] of Object.entries(await loadCatalogue(locale))) {
      if (typeof text === "string") continue;
      expect(Object.keys(text).sort(), key).toEqual(needed);
      expect(
        places(text).some((place) => place === "count" || place === "most"),
        key,
      ).toBe(true);
    }
  });
  it("choose the form by the number", () => {
    const members = { one: "{count} član", few: "{count} člana", other: "{count} članova" };
    const said = (count: number) => formOf(members, count, new Intl.PluralRules("sr-Latn"));
    expect([1, 2, 5, 11, 21, 22].map(said)).toEqual([
      "{count} član",
      "{count} člana",
      "{count} članova",
      "{count} članova",
      "{count} član",
      "{count} člana",
    ]);
  });
  it("are split for loading without a loss", () => {
    expect({ ...first, ...rest, ...lessons }).toEqual(en);
    expect(Object.keys(lessons).filter((key) => !key.startsWith("lesson_"))).toEqual([]);
    expect(Object.keys(first).filter((key) => key in rest)).toEqual([]);
    expect(first).toHaveProperty("stop");
    expect(rest).toHaveProperty("refused_no_rig");
  });
  it("leave no Serbian word in Latin letters when Cyrillic is chosen", async () => {
    const catalogue = await loadCatalogue("sr-Cyrl");
    for (const key of keys) {
      const kept = forms(catalogue[key])
        .join("\n")
        .replace(/\{\w+\}/g, "");
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
  it("keep units in Latin, beside a number, a place and a label", async () => {
    expect(toCyrillic("od 2 V do {high} V za 5 s, {delay} s s tim")).toBe(
      "од 2 V до {high} V за 5 s, {delay} s с тим",
    );
    expect(toCyrillic("Trajanje, s")).toBe("Трајање, s");
    expect(toCyrillic("Do, s tim danom")).toBe("До, с тим даном");
    const latin = await loadCatalogue("sr-Latn");
    const cyrillic = await loadCatalogue("sr-Cyrl");
    const symbols = "ms|s|V|A|Hz|kHz|mV|px|mm|min|kB|MB|GB|rpm|ohm";
    const place = `(?:\\d|\\{\\w+\\}),? |, (?=(?:${symbols})$)`;
    const unit = new RegExp(`(?:${place})(${symbols})(?![\\p{L}\\d])`, "gmu");
    const units = (text: Text | undefined) =>
      [...forms(text).join("\n").matchAll(unit)].map((match) => match[1]);
    expect(keys.filter((key) => units(latin[key]).length > 0).length).toBeGreaterThan(40);
    for (const key of keys) expect(units(cyrillic[key]), key).toEqual(units(latin[key]));
    // what stands in capitals is an abbreviation or a symbol, except these words
    const words = "А|И|К|О|С|У|ПРЕГЛЕД|ПОГРЕШНИ";
    for (const key of keys)
      for (const form of forms(cyrillic[key]))
        expect(
          [...form.matchAll(/(?<![\p{L}\d])[А-ЯЂЈЉЊЋЏ]+(?![\p{L}\d])/gu)]
            .map(([word]) => word)
            .filter((word) => !words.split("|").includes(word)),
          key,
        ).toEqual([]);
  });
  it("fill their places", () => {
    expect(fill("{a} of {b}", { a: 1 })).toBe("1 of {b}");
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

  it("every verb of the audit log is said in the reader's language", () => {
    const verbs = [
      ...all(/audit\.Add(?:Bounded)?\(\s*\{?[\w.() ]+,\s*"([a-z_]+)"/g),
      ...all(/AuditNote\s+\w+\{\s*[\w.() ]+,\s*"([a-z_]+)"/g),
      ...all(/note\("([a-z_]+)"\)/g),
      ...all(/'system', '([a-z_]+)'/g),
    ];
    expect(verbs.length).toBeGreaterThan(20);
    const onTheServer = all(/\bAudit\(\s*accounts,\s*"([a-z_]+)"/g);
    expect(onTheServer.length, "faultlab admin").toBeGreaterThan(2);
    verbs.push(...onTheServer);
    const known = all(/^ {4}"([a-z_]+)",$/gm, auditVerbs);
    expect(verbs.filter((verb) => !known.includes(verb))).toEqual([]);
    const said = keys.filter((key) => key.startsWith("audit_"));
    expect(said.sort()).toEqual(known.map((verb) => `audit_${verb}`).sort());
  });
  it("every check of the healthy beginning has a sentence", () => {
    const checks = all(/Judge\(\s*checks,\s*"([a-z]+)"/g, stretchChecks);
    expect(checks.length).toBeGreaterThan(6);
    expect(checks.filter((check) => !keys.some((key) => key === `check_${check}`))).toEqual([]);
    const unknown = "not calibrated, check 'other' failed: 1 V";
    expect(rigWords(unknown)).toBe(unknown);
  });
  it("the detail of a line of the log is told member by member", () => {
    expect(detailWords("role student; enabled; name")).toBe("Role: student, enabled, Name");
    expect(detailWords("from 10.0.0.1")).toBe("from 10.0.0.1");
    expect(detailWords("worn belt; see the note")).toBe("worn belt; see the note");
    expect(detailWords("2026-11-23T18:34:06Z worn belt")).not.toContain("T18:34");
    const line = { id: 1, at: "", actor: "user:1", actor_login: "mila", object_name: "" };
    const run = { verb: "delete_run", object: "run:rec-1", detail: "of user:4" };
    expect(auditLine({ ...line, ...run, object_login: "ann" }).what).toBe(
      "deleted the run rec-1 of ann",
    );
    expect(detailWords("2026-11-25T10:03:00Z 2026-11-25T12:03:00Z new brushes")).toMatch(
      /^Wed 25 Nov.*–.*: new brushes$/,
    );
    expect(objectWords("course:1")).toBe("1");
  });
  it("a line of the log is a sentence with names, none of them twice", () => {
    const entry = {
      id: 1,
      at: "",
      actor: "user:2",
      actor_login: "vera",
      object_name: "",
      detail: "",
    };
    const line = (rest: object) =>
      Object.values(auditLine({ ...entry, verb: "", object: "", object_login: "", ...rest })).join(
        "|",
      );
    const course = { object: "course:1", object_name: "Motors" };
    expect(line({ verb: "invite", ...course, detail: "ana" })).toBe(
      "vera|invited to the course Motors: ana|",
    );
    const ana = { object: "user:3", object_login: "ana" };
    expect(line({ verb: "end_enrolment", ...ana, detail: "Motors" })).toBe(
      "vera|took ana out of the course Motors|",
    );
    expect(line({ verb: "create_user", ...ana })).toBe("vera|made the user ana|");
    const guest = { actor: "guest", actor_login: "" };
    expect(line({ verb: "use_reset_link", ...ana, ...guest })).toBe(
      "ana|set the password with a link|",
    );
    expect(line({ verb: "quarantine", object: "rig:bench-1", detail: "smoke" })).toBe(
      "vera|quarantined bench-1|smoke",
    );
    expect(line({ verb: "of_tomorrow", object: "rig:x" })).toBe("vera|of tomorrow x|");
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
    ["alarm", schemas.Alarm.properties.kind.enum],
    ["alarm", schemas.Alarm.properties.kind.enum.map((kind) => `${kind}_do`)],
    ["step", schemas.CheckStep.properties.step.enum],
    ["check_kind", schemas.RigCheck.properties.kind.enum],
  ])("every %s is said in the reader's language", (group, values) => {
    expect(values.filter((value) => !keys.some((key) => key === `${group}_${value}`))).toEqual([]);
  });
});

describe("keys", () => {
  it("are loaded before a part that is loaded late", () => {
    const files = import.meta.glob("../src/**/*.{svelte,ts}", {
      query: "?raw",
      import: "default",
      eager: true,
    }) as Record<string, string>;
    const bare = Object.entries(files)
      .filter(([path]) => !/\/(App\.svelte|circuits\.ts|learn\/.*|pages\/.*)$/.test(path))
      .flatMap(([path, source]) =>
        [...source.matchAll(/(late\(\(\) => )?import\("(\.[^"]+\.svelte)"\)/g)]
          .filter((found) => !found[1])
          .map((found) => `${path}: ${found[2]}`),
      );
    expect(bare).toEqual([]);
  });
  it("are all used by the page", () => {
    const sources = import.meta.glob("../src/**/*.{svelte,ts}", {
      query: "?raw",
      import: "default",
      eager: true,
    }) as Record<string, string>;
    const text = Object.entries(sources)
      .filter(([path]) => !/\/i18n\/(languages|i18n)/.test(path))
      .map(([, source]) => source)
      .join("\n");
    const groups = [...text.matchAll(/\b(?:word\("(\w+)"|t\(`(\w+_)\$)/g)].map(
      ([, group, prefix]) => prefix ?? `${group}_`,
    );
    groups.push("news_"); // by topic of a lab event
    groups.push("refused_", "field_", "trip_", "detector_"); // by reason of a refusal, by member of a request
    groups.push("audit_", "check_"); // by verb of the audit log, by check of the calibration
    groups.push("failed_oidc_"); // by the word of a refused sign-in
    const used = (key: string) =>
      text.includes(`"${key}"`) || groups.some((group) => key.startsWith(group));
    expect(keys.filter((key) => !used(key))).toEqual([]);
  });
});
