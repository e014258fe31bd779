import type { Component, Finding, RunEvent } from "../api/types";
import type { Bench } from "../plant/bench";

/** A component has another value since `atS`: the rig has confirmed it. */
export interface Change {
  component: Component;
  value: number;
  /** Its value until then. */
  before: number;
  atS: number;
  nominal: boolean;
  /** Components that were not nominal then, this one aside. */
  others: Component[];
}

/** One alarm, and what was named after it. */
export interface Detection {
  atS: number;
  /** Since the change that the rig has confirmed last before it; null: there was none. */
  delayS: number | null;
  isolatedS: number | null;
  /** One component, or several that look alike; empty: nothing was named. */
  named: readonly Component[];
  /** Whether it belongs to a return to nominal, or to a further change of the same fault. */
  of: "first" | "further" | "return";
}

/** A stretch in which the rig is not nominal: what happened, when, and what is known of it. */
export interface Episode {
  /** Of the rig, in time order; empty when no rig has reported a change. */
  changes: Change[];
  detections: Detection[];
  /** Its first change, otherwise the diagnosis' estimate, otherwise its first detection. */
  onsetS: number;
  endedS: number | null;
  finding: Finding | null;
}

export interface Story {
  episodes: Episode[];
  /** All changes that the rig has confirmed, those back to nominal too. */
  changes: Change[];
  /** Without what was reported twice, in time order. */
  events: RunEvent[];
}

/** What a story is made of: all of a run's record, or the short form in a list of runs. */
export interface Sources {
  events: readonly RunEvent[];
  /** What the server says now. */
  verdict?: Finding | null;
  /** All that it has said, when the run is over. */
  findings?: readonly Finding[];
}

/** Times that went through JSON are equal within this. */
const SAME_S = 1e-6;

/**
 * The one account of a run that verdict, tables, markers and lists are made from. An episode
 * belongs to one component: a change of another one begins the next.
 */
export function tellStory(sources: Sources, bench: Bench, periodS: number): Story {
  const events = inOrder(sources.events);
  const teller = new Teller(bench, periodS);
  for (const event of events) teller.hear(event);
  for (const finding of sources.findings ?? []) teller.find(finding);
  if (sources.verdict) teller.findNow(sources.verdict);
  return { episodes: teller.episodes, changes: teller.changes, events };
}

/** The episode that the page is about: the newest. */
export function newest(story: Story): Episode | null {
  return story.episodes.at(-1) ?? null;
}

/** Since when the values that were found hold: the newest change, as the diagnosis estimates it. */
export function newestOnset({ finding, onsetS }: Episode): number {
  const again = finding?.further?.at(-1);
  return again ? (again.onset_s ?? again.detected_at_s) : (finding?.onset_s ?? onsetS);
}

/** When something changed: for each, the estimators' windows hold samples from before it. */
export function changeTimes(story: Story): number[] {
  const unreported = story.episodes.filter((each) => each.changes.length === 0);
  const found = unreported.flatMap((each) => [
    each.onsetS,
    ...(each.finding?.further ?? []).map((one) => one.onset_s ?? one.detected_at_s),
  ]);
  return [...story.changes.map((each) => each.atS), ...found].sort((a, b) => a - b);
}

/** The episode in which a detection at `atS` was named. */
export function episodeAt(story: Story, atS: number): Episode | null {
  return story.episodes.findLast((each) => each.onsetS <= atS + SAME_S) ?? null;
}

/**
 * In time order, and each thing once: the same detection may have been recorded twice, the second
 * time after later events, and what it was named may have been refined.
 */
function inOrder(events: readonly RunEvent[]): RunEvent[] {
  const detected = new Set<number>();
  const once = events.filter((event) => {
    if (event.kind !== "detected") return true;
    if (detected.has(event.index)) return false;
    detected.add(event.index);
    return true;
  });
  once.sort((a, b) => a.index - b.index); // stable: as recorded where the times agree
  const told: RunEvent[] = [];
  let isolation = -1; // where the isolation of the newest detection stands
  for (const event of once) {
    if (/^(detected|returned|learning)$/.test(event.kind)) isolation = -1;
    if (event.kind !== "isolated") told.push(event);
    else if (isolation < 0) isolation = told.push(event) - 1;
    else told[isolation] = { ...event, index: (told[isolation] as RunEvent).index };
  }
  return told;
}

class Teller {
  readonly episodes: Episode[] = [];
  readonly changes: Change[] = [];
  private readonly values = new Map<Component, number>();
  /** Commanded and not yet confirmed: a drift is confirmed when it has come to its end. */
  private readonly commandedS = new Map<Component, number>();

  constructor(
    private readonly bench: Bench,
    private readonly periodS: number,
  ) {}

  hear(event: RunEvent): void {
    const atS = event.index * this.periodS;
    const { component, value } = event;
    switch (event.kind) {
      case "fault_commanded":
        if (component && !this.commandedS.has(component)) this.commandedS.set(component, atS);
        break;
      case "relay_confirmed":
        if (component && typeof value === "number") this.change(component, value, atS);
        break;
      case "detected":
        this.detect(atS);
        break;
      case "isolated":
        this.isolate(event.components ?? (component ? [component] : []), atS);
        break;
      case "returned":
        this.end(atS);
        break;
      case "learning":
        this.end(atS); // the diagnosis begins anew
        break;
      case "trip":
        for (const name of this.faulty()) this.change(name, this.bench.nominal(name), atS);
        break;
      default:
        break;
    }
  }

  /** A finding belongs to the episode in which it was detected. */
  find(finding: Finding): void {
    const atS = finding.detected_at_s ?? finding.onset_s;
    if (atS === null || atS === undefined) return;
    const found = this.episodes.findLast((each) => this.holds(each, atS));
    if (found?.detections.some((each) => each.of === "return" && near(each.atS, atS))) return;
    const episode = found ?? this.add(finding.onset_s ?? atS);
    episode.finding = finding;
    if (episode.changes.length === 0) episode.onsetS = finding.onset_s ?? atS;
    if (episode.detections.length === 0) {
      this.noteDetection(episode, atS);
      for (const again of finding.further ?? []) this.noteDetection(episode, again.detected_at_s);
    }
    if (finding.ended_at_s !== null && finding.ended_at_s !== undefined) {
      episode.endedS ??= finding.ended_at_s;
    }
    this.episodes.sort((a, b) => a.onsetS - b.onsetS);
  }

  /** The verdict of the moment: of the newest episode that was detected. */
  findNow(verdict: Finding): void {
    if (verdict.verdict !== "fault" && verdict.verdict !== "unknown_fault") return;
    const episode =
      this.episodes.find((each) => near(each.finding?.detected_at_s, verdict.detected_at_s)) ??
      this.episodes.findLast((each) => each.detections.length > 0);
    if (!episode) {
      this.find(verdict);
      return;
    }
    const returning = episode.detections.at(-1);
    if (returning?.of === "return" && near(returning.atS, verdict.detected_at_s)) return;
    episode.finding = { ...verdict, ended_at_s: episode.finding?.ended_at_s };
    if (episode.changes.length === 0) episode.onsetS = verdict.onset_s ?? episode.onsetS;
  }

  private change(component: Component, value: number, atS: number): void {
    const sinceS = this.commandedS.get(component) ?? atS;
    this.commandedS.delete(component);
    const before = this.values.get(component) ?? this.bench.nominal(component);
    const others = this.faulty().filter((name) => name !== component);
    this.values.set(component, value);
    const nominal = this.bench.isNominal(component, value);
    if (nominal && this.bench.isNominal(component, before)) return; // it was and stays healthy
    const change = { component, value, before, atS, nominal, others };
    this.changes.push(change);
    const open = this.episodes.findLast(
      (each) => each.endedS === null && each.changes.at(-1)?.component === component,
    );
    const episode = open ?? this.unreported(sinceS, atS) ?? this.add(atS);
    episode.changes.push(change);
    if (nominal) episode.endedS = atS;
  }

  /** A detection a sample before the rig's report, or while a part drifts, belongs to that change. */
  private unreported(sinceS: number, atS: number): Episode | undefined {
    const last = this.episodes.at(-1);
    const fresh = last && last.endedS === null && last.changes.length === 0;
    const about = 2 * this.periodS;
    return fresh && last.onsetS >= sinceS - about && last.onsetS <= atS + about ? last : undefined;
  }

  private detect(atS: number): void {
    const last = this.episodes.at(-1);
    const known = last && (last.endedS === null || last.changes.length > 0);
    const episode = known && this.expectsDetection(last) ? last : this.add(atS);
    this.noteDetection(episode, atS);
  }

  /** Whether an alarm now is of this episode: its changes explain it, or nothing has reported any. */
  private expectsDetection(episode: Episode): boolean {
    if (episode.endedS === null) return true;
    return !episode.detections.some((each) => each.of === "return");
  }

  private noteDetection(episode: Episode, atS: number): void {
    const cause = episode.changes.findLast((each) => each.atS <= atS + SAME_S);
    episode.detections.push({
      atS,
      delayS: cause ? atS - cause.atS : null,
      isolatedS: null,
      named: [],
      of: cause?.nominal ? "return" : episode.detections.length > 0 ? "further" : "first",
    });
  }

  private isolate(named: readonly Component[], atS: number): void {
    const detection = this.episodes.at(-1)?.detections.at(-1);
    if (!detection) return;
    detection.isolatedS ??= atS;
    detection.named = named;
  }

  private end(atS: number): void {
    const last = this.episodes.at(-1);
    if (last) last.endedS ??= atS;
  }

  private holds(episode: Episode, atS: number): boolean {
    return episode.onsetS <= atS + SAME_S || episode.detections.some((each) => near(each.atS, atS));
  }

  private add(onsetS: number): Episode {
    const episode: Episode = {
      changes: [],
      detections: [],
      onsetS,
      endedS: null,
      finding: null,
    };
    this.episodes.push(episode);
    return episode;
  }

  private faulty(): Component[] {
    return [...this.values]
      .filter(([name, value]) => !this.bench.isNominal(name, value))
      .map(([name]) => name);
  }
}

function near(a: number | null | undefined, b: number | null | undefined): boolean {
  return typeof a === "number" && typeof b === "number" && Math.abs(a - b) <= SAME_S;
}
