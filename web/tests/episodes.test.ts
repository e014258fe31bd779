import { beforeAll, describe, expect, it } from "vitest";
import type { Finding, RunEvent } from "../src/api/types";
import { i18n } from "../src/i18n/i18n.svelte";
import { announcementOf } from "../src/live/announcements";
import { spanAround } from "../src/live/before_after";
import {
  changeTimes,
  type Episode,
  episodeAt,
  newest,
  newestOnset,
  type Sources,
  tellStory,
} from "../src/live/episodes";
import { isolatedBy, verdictWords } from "../src/live/verdict_words";
import { bench } from "./support/bench";

beforeAll(() => i18n.loadAll());

const PERIOD = 0.01;
const event = (kind: RunEvent["kind"], atS: number, more: Partial<RunEvent> = {}): RunEvent => ({
  kind,
  index: Math.round(atS / PERIOD),
  t_s: atS,
  ...more,
});
const confirmed = (component: string, value: number, atS: number) =>
  event("relay_confirmed", atS, { component, value });
const isolated = (component: string, atS: number) =>
  event("isolated", atS, { component, value: 1 });

function finding(component: string, atS: number, more: Partial<Finding> = {}): Finding {
  const candidate = {
    component,
    value: 56,
    sigma: 1,
    unit: "ohm",
    bound: null,
    score: 1,
    margin: 0,
  };
  return {
    verdict: "fault",
    detected_at_s: atS,
    onset_s: atS,
    group: [component],
    candidates: [candidate],
    settled: true,
    ...more,
  };
}
const tell = (sources: Sources) => tellStory(sources, bench, PERIOD);

describe("a part that drifts", () => {
  const drift = [
    event("fault_commanded", 10, { component: "R1", value: 10 }),
    event("detected", 10.5),
    isolated("R1", 10.5),
    confirmed("R1", 10, 20),
    event("fault_commanded", 35, { component: "R1", value: 2 }),
    confirmed("R1", 2, 35),
    event("detected", 35),
    event("returned", 36),
  ];

  it("is one episode, which its detection belongs to although the rig reports its end", () => {
    const story = tell({ events: drift, findings: [finding("R1", 10.5, { ended_at_s: 35 })] });
    expect(story.episodes).toHaveLength(1);
    expect(story.episodes[0]?.changes.map((each) => [each.value, each.atS])).toEqual([
      [10, 20],
      [2, 35],
    ]);
    expect(story.episodes[0]?.detections.map((each) => [each.atS, each.of])).toEqual([
      [10.5, "first"],
      [35, "return"],
    ]);
    expect(story.episodes[0]?.finding?.group).toEqual(["R1"]);
  });

  it("is another one than what was detected before it began to", () => {
    const story = tell({ events: [event("detected", 8), ...drift.slice(0, 1), ...drift.slice(3)] });
    expect(story.episodes.map((each) => each.changes.length)).toEqual([0, 2]);
  });
});

describe("an uploaded record, of which no rig has reported anything", () => {
  it("has the further changes of a fault, and their times", () => {
    const further = [{ detected_at_s: 14.03, onset_s: 14, detector: "residual" }];
    const story = tell({ events: [], findings: [finding("R12", 8, { further })] });
    expect(newest(story)?.detections.map((each) => [each.atS, each.of])).toEqual([
      [8, "first"],
      [14.03, "further"],
    ]);
    expect(changeTimes(story)).toEqual([8, 14]);
  });

  it("has the newest value since the newest change", () => {
    const since = (more: Partial<Finding>) =>
      newestOnset(newest(tell({ events: [], findings: [finding("R12", 8, more)] })) as Episode);
    const again = { detected_at_s: 14.03, detector: "residual" };
    expect(since({ onset_s: 7.98 })).toBe(7.98);
    expect(since({ onset_s: 7.98, further: [{ ...again, onset_s: 14 }] })).toBe(14);
    expect(since({ onset_s: 7.98, further: [{ ...again, onset_s: null }] })).toBe(14.03);
  });
});

describe("the story of a run", () => {
  /** As a server recorded it: the first detection came again after the second. */
  const twice = [
    event("started", 0),
    confirmed("R1", 100, 10),
    event("detected", 10),
    isolated("R1", 10.26),
    confirmed("R1", 220, 18),
    event("detected", 18.02),
    event("detected", 10),
    isolated("R1", 18.26),
  ];

  it("has one episode of a component that was changed twice, about its last value", () => {
    const said = finding("R1", 10);
    const story = tell({ events: twice, verdict: said, findings: [said] });
    expect(story.episodes).toHaveLength(1);
    const episode = newest(story);
    expect(episode?.onsetS).toBe(10);
    expect(episode?.changes.map(({ before, value }) => [before, value])).toEqual([
      [2, 100],
      [100, 220],
    ]);
    expect(episode?.detections.map((each) => each.of)).toEqual(["first", "further"]);
    expect(episode?.detections[1]?.delayS).toBeCloseTo(0.02);
    expect(episode?.finding).toMatchObject(said);
  });

  it("tells each detection once, in time order", () => {
    const { events } = tell({ events: twice });
    expect(events.filter((each) => each.kind === "detected").map((each) => each.index)).toEqual([
      1000, 1802,
    ]);
    expect(events.map((each) => each.index)).toEqual(
      events.map((each) => each.index).sort((a, b) => a - b),
    );
  });

  it("ends an episode when the part is nominal again; the next fault is another one", () => {
    const events = [
      confirmed("R1", 100, 8),
      event("detected", 8),
      isolated("R1", 8.26),
      confirmed("R1", 2, 14),
      event("detected", 14),
      event("returned", 15.01),
      confirmed("R12", 2000, 20),
      event("detected", 20),
      isolated("R12", 20.26),
    ];
    const findings = [finding("R1", 8, { ended_at_s: 14 }), finding("R12", 20)];
    const story = tell({ events, verdict: findings[1], findings });
    expect(story.episodes.map((each) => [each.onsetS, each.endedS])).toEqual([
      [8, 14],
      [20, null],
    ]);
    expect(story.episodes[0]?.detections.map((each) => each.of)).toEqual(["first", "return"]);
    expect(story.episodes.map((each) => each.finding?.group)).toEqual([["R1"], ["R12"]]);
  });

  it("keeps a return that is being worked out apart from what was found before", () => {
    const events = [
      confirmed("R1", 100, 8),
      event("detected", 8),
      confirmed("R1", 2, 14),
      event("detected", 14),
    ];
    const first = finding("R1", 8, { ended_at_s: 14 });
    const unclear = finding("R1", 14, { group: [], candidates: [], settled: false });
    const story = tell({ events, verdict: unclear, findings: [first, unclear] });
    expect(story.episodes).toHaveLength(1);
    expect(newest(story)?.finding).toEqual(first);
  });

  it("gives a second component an episode of its own, and knows that the first is still there", () => {
    const story = tell({ events: [confirmed("R1", 100, 8), confirmed("R12", 2000, 12)] });
    expect(story.episodes).toHaveLength(2);
    expect(story.changes[1]?.others).toEqual(["R1"]);
  });

  it("is told by the diagnosis alone where no rig reports", () => {
    const said = finding("R1", 7.3, { onset_s: 7.1 });
    const story = tell({ events: [event("detected", 7.3)], verdict: said, findings: [said] });
    expect(story.changes).toEqual([]);
    expect(newest(story)).toMatchObject({ onsetS: 7.1, finding: said });
    expect(newest(story)?.detections).toHaveLength(1);
  });

  it("of a healthy run is empty", () => {
    const nominal: Finding = {
      verdict: "nominal",
      detected_at_s: null,
      onset_s: null,
      group: [],
      candidates: [],
    };
    const story = tell({ events: [confirmed("R1", 2, 3)], verdict: nominal, findings: [] });
    expect(story.episodes).toEqual([]);
    expect(story.changes).toEqual([]);
  });

  it("is announced once for each detection, and says which kind it is", () => {
    const say = (at: number) => {
      const events = twice.slice(0, at + 1);
      return announcementOf(twice[at] as RunEvent, tell({ events }), bench, PERIOD);
    };
    expect(say(2)).toBe("Fault detected at 10.00 seconds.");
    expect(say(5)).toBe("A further change was detected at 18.02 seconds.");
    expect(say(6)).toBe(null);
  });

  it("announces and lists all that look alike, in the order of the bench", () => {
    const events = [confirmed("R12", 2000, 8), event("detected", 8), isolated("R12", 8.26)];
    const verdict = finding("R12", 8, { group: ["R12", "R1"] });
    const story = tell({ events, verdict });
    const said = announcementOf(events[2] as RunEvent, story, bench, PERIOD);
    expect(said).toBe("Fault isolated: R1 or R12, at 8.26 seconds.");
    expect(episodeAt(story, 8.26)?.finding).toMatchObject(verdict);
    expect(isolatedBy({ component: "J" }, verdict, bench)).toEqual(["J"]); // before it changed
    const group = { components: ["R1", "R12"] };
    expect(isolatedBy(group, null, bench)).toEqual(["R1", "R12"]); // a group stays one
  });

  it("tells an isolation once for each detection, with what was named last", () => {
    const events = [
      event("detected", 8),
      event("isolated", 8.26, { components: ["R12"], component: "R12", value: 2000 }),
      event("isolated", 9, { components: ["R1", "R12"] }),
      event("detected", 12),
      event("isolated", 12.5, { components: ["R1", "R12"] }),
    ];
    const story = tell({ events });
    const told = story.events.filter((each) => each.kind === "isolated");
    expect(told.map((each) => [each.index * PERIOD, each.components])).toEqual([
      [8.26, ["R1", "R12"]],
      [12.5, ["R1", "R12"]],
    ]);
    const detections = story.episodes.flatMap((each) => each.detections);
    expect(detections.map((each) => each.named)).toEqual([
      ["R1", "R12"],
      ["R1", "R12"],
    ]);
    expect(detections[0]?.isolatedS).toBe(8.26);
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
  it("name the component and its direction, or all that look alike", () => {
    expect(verdictWords(finding("R1", 10), bench)).toBe("Fault: R1 ↑");
    expect(verdictWords(finding("R1", 10, { group: ["R12", "R1"] }), bench)).toBe(
      "Fault: R1 or R12",
    );
    expect(verdictWords(finding("R1", 10, { verdict: "unknown_fault" }), bench)).toBe(
      "Unknown fault",
    );
  });
});
