import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { i18n } from "../src/i18n/i18n.svelte";
import { rigTrouble } from "../src/i18n/rig_words";
import { Benches } from "../src/shell/benches.svelte";
import { rigs } from "../src/shell/rigs.svelte";
import { ABOUT, DRIVER, know, rigOf } from "./support/bench";

/** Answers of the server, given when the test says. */
const asked = new Map<string, ((answer: unknown, status?: number) => void)[]>();
const says = (path: string, answer: unknown, status = 200) => {
  for (const answered of asked.get(path) ?? []) answered(answer, status);
  asked.delete(path);
};
const settled = () => new Promise((resume) => setTimeout(resume));

beforeEach(() => {
  vi.stubGlobal("fetch", (address: string) => {
    const path = address.replace("/api/v1", "");
    return new Promise((resolve) => {
      const waiting = asked.get(path) ?? [];
      waiting.push((answer, status) => resolve(Response.json(answer, { status })));
      asked.set(path, waiting);
    });
  });
});
afterEach(() => {
  asked.clear();
  vi.unstubAllGlobals();
});

describe("benches", () => {
  it("come with the list, the first is the server's first", async () => {
    const benches = new Benches();
    const done = benches.load();
    says("/benches", { items: [DRIVER, ABOUT] });
    await done;
    expect(benches.first?.title).toBe(DRIVER.title);
    expect((await benches.need(ABOUT.id)).about).toEqual(ABOUT);
    expect(asked.size).toBe(0); // nothing more was fetched
  });

  it("of an old run are fetched once by their id", async () => {
    const benches = new Benches();
    void benches.load();
    const both = Promise.all([benches.need(ABOUT.id), benches.need(ABOUT.id)]);
    await settled();
    expect([...asked.keys()]).toEqual(["/benches"]); // it may be in the list
    says("/benches", { items: [DRIVER] });
    await settled();
    expect(asked.get(`/benches/${ABOUT.id}`)).toHaveLength(1);
    says(`/benches/${ABOUT.id}`, ABOUT);
    const [one, other] = await both;
    expect(one).toBe(other);
    expect(await benches.need(ABOUT.id)).toBe(one);
    expect(asked.size).toBe(0);
    expect(benches.list.map((bench) => bench.id)).toEqual([DRIVER.id]);
  });

  it("that the server does not know fail with its reason, and may be asked for again", async () => {
    const benches = new Benches();
    for (let turn = 0; turn < 2; turn++) {
      const answer = benches.need("gone-1");
      await settled();
      says("/benches/gone-1", { detail: "No such bench." }, 404);
      await expect(answer).rejects.toThrow("No such bench.");
    }
  });

  it("that are only drawn are asked for once, however often they are drawn", async () => {
    const benches = new Benches();
    for (let turn = 0; turn < 3; turn++) {
      expect(benches.find("gone-2")).toBeUndefined();
      await settled();
      says("/benches/gone-2", { detail: "No such bench." }, 404);
      await settled();
    }
    expect(asked.size).toBe(0);
    expect(benches.find(undefined)).toBeUndefined();
  });

  it("are asked for again when the list did not come", async () => {
    const benches = new Benches();
    const first = benches.load();
    says("/benches", {}, 500);
    await expect(first).rejects.toThrow();
    const second = benches.load();
    says("/benches", { items: [ABOUT] });
    await second;
    expect(benches.list).toHaveLength(1);
  });
});

describe("rigs", () => {
  it("are grouped by their bench", () => {
    know(
      [ABOUT, DRIVER],
      [
        rigOf("a", true),
        rigOf("b", true, DRIVER),
        rigOf("c", false),
        { ...rigOf("d", true), bench: null },
      ],
    );
    const groups = rigs.groups.map(({ bench, rigs }) => [bench?.title, rigs.map((rig) => rig.id)]);
    expect(groups).toEqual([
      [ABOUT.title, ["a", "c"]],
      [DRIVER.title, ["b"]],
      [undefined, ["d"]],
    ]);
  });

  it("for a plan that names none are simulated ones of its bench, a free one first", () => {
    const busy = { ...rigOf("b-1", true, DRIVER), state: "running" as const };
    know([ABOUT, DRIVER], [rigOf("a", true), busy, rigOf("b-2", true, DRIVER)]);
    const [first, second] = rigs.groups;
    expect(rigs.simulated(first?.bench)?.id).toBe("a");
    expect(rigs.simulated(second?.bench)?.id).toBe("b-2");
    rigs.list = [busy];
    expect(rigs.simulated(second?.bench)?.id).toBe("b-1");
    expect(rigs.simulated(first?.bench)).toBeUndefined();
  });

  it("that are refused say the code's sentence, with what to do", async () => {
    await i18n.loadAll();
    const link = {
      state: "lost",
      silent_s: 3,
      behind: "bench",
      key_known: false,
      holder: "",
      held_by_us: false,
      round_trip_s: 0,
      clock_offset_s: null,
      refilled: 0,
      seen_epoch: null,
      refusal: "no_key",
    } as const;
    const health = "its key is not here: copy its .key file";
    const rig = { ...rigOf("far-1", false), health, link, reason: "the rig does not answer" };
    expect(rigTrouble(rig)).toMatch(/^The key of far-1 is not on this server\./);
    expect(rigTrouble({ ...rig, link: { ...link, refusal: null } })).toBe(
      "The rig does not answer",
    );
    expect(rigTrouble({ ...rig, reason: "", link: { ...link, refusal: null } })).toBe(health);
    expect(rigTrouble(rigOf("a", true))).toBe("");
  });
});
