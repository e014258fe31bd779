import { beforeAll, describe, expect, it } from "vitest";
import type { RunEvent, Story } from "../src/contract/types";
import { i18n } from "../src/i18n/i18n.svelte";
import { announcementOf } from "../src/live/announcements";
import { spanAround } from "../src/live/before_after";
import { isolationAt, sealedFrom } from "../src/live/story";
import { certaintyOf, verdictWords } from "../src/live/verdict_words";
import { bench } from "./support/bench";
import { change, episode, finding, NOTHING } from "./support/stories";

beforeAll(() => i18n.loadAll());

const PERIOD = 0.01;
const event = (kind: RunEvent["kind"], atS: number): RunEvent => ({
  kind,
  index: Math.round(atS / PERIOD),
  t_s: atS,
});
const R12 = finding("R12", 8, { group: ["R12", "R1"] });
const found: Story = {
  episodes: [episode(8, { changes: [change("R12", 2000, 8)], finding: R12 })],
  changes: [change("R12", 2000, 8)],
  change_times_s: [8],
  set_back: false,
};

describe("the announcement of an event", () => {
  const say = (of: RunEvent, story: Story) => announcementOf(of, story, bench, PERIOD);

  it("names all that look alike, also what is named later", () => {
    const named = { ...event("isolated", 8.26), components: ["R1", "R12"] };
    expect(say(named, found)).toBe("Fault isolated: R1 or R12, at 8.26 seconds.");
    expect(isolationAt(found, 8.26)?.episode.finding).toEqual(R12);
    expect(isolationAt(found, 9)).toBe(undefined);
  });

  it("says which kind of alarm it is, and nothing of one that is told already", () => {
    const of = (kind: "further" | "return") => {
      const alarm = { detected_at_s: 14, delay_s: 0, isolated_at_s: null, named: [], of: kind };
      const [first = episode(8)] = found.episodes;
      return { ...found, episodes: [{ ...first, detections: [...first.detections, alarm] }] };
    };
    expect(say(event("detected", 8), found)).toBe("Fault detected at 8.00 seconds.");
    expect(say(event("detected", 14), of("further"))).toBe(
      "A further change was detected at 14.00 seconds.",
    );
    expect(say(event("detected", 8), of("return"))).toBe(null);
  });
});

describe("the story of an exercise whose fault is hidden", () => {
  const second = episode(20, {
    changes: [change("R1", 100, 20)],
    detections: [
      { detected_at_s: 20.01, delay_s: 0.01, isolated_at_s: 20.3, named: ["R1"], of: "first" },
    ],
    finding: finding("R1", 20.01),
  });
  const both: Story = {
    episodes: [...found.episodes, second],
    changes: [...found.changes, change("R1", 100, 20)],
    change_times_s: [8, 20],
    set_back: false,
  };

  it("has the alarm, and nothing that tells the part or when it was changed", () => {
    const sealed = sealedFrom(both, 20);
    expect(sealed.episodes[0]).toEqual(both.episodes[0]);
    expect(sealed.episodes[1]).toEqual({
      onset_s: 20.01,
      since_s: 20.01,
      ended_s: null,
      changes: [],
      detections: [
        { detected_at_s: 20.01, delay_s: null, isolated_at_s: null, named: [], of: "first" },
      ],
      finding: null,
    });
    expect(sealed.changes).toEqual(found.changes);
    expect(sealed.change_times_s).toEqual([8, 20.01]);
  });

  it("has nothing of it before an alarm", () => {
    expect(sealedFrom({ ...both, episodes: [{ ...second, detections: [] }] }, 20).episodes).toEqual(
      [],
    );
    expect(sealedFrom(NOTHING, 20)).toEqual(NOTHING);
  });
});

describe("the table of before and after", () => {
  it("looks between the neighbouring changes only", () => {
    expect(spanAround(18, [10, 18, 25], 30)).toEqual({ fromS: 10, atS: 18, toS: 25 });
    expect(spanAround(10, [10], 30)).toEqual({ fromS: 0, atS: 10, toS: 30 });
    expect(spanAround(null, [], 30)).toEqual({ fromS: 0, atS: null, toS: 30 });
  });
});

describe("the words of a verdict", () => {
  it("says how sure it is, of an older recording nothing", () => {
    const { candidates } = finding("R1", 10);
    const sure = (...of: number[]) =>
      certaintyOf(
        of.flatMap((probability) => candidates.map((each) => ({ ...each, probability }))),
      );
    expect(sure(0.6, 0.39995)).toBe("> 99.9 %");
    expect(sure(0.5, 0.47)).toBe("97 %");
    expect(sure(0.9945)).toBe("99.5 %");
    expect(certaintyOf(candidates)).toBeNull();
  });
  it("name the component and its direction, or all that look alike", () => {
    expect(verdictWords(finding("R1", 10), bench)).toBe("Fault: R1 ↑");
    expect(verdictWords(R12, bench)).toBe("Fault: R1 or R12");
    expect(verdictWords(finding("R1", 10, { verdict: "unknown_fault" }), bench)).toBe(
      "Unknown fault",
    );
  });
});
