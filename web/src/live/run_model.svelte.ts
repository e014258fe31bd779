import { ApiError, api, call } from "../api/client";
import type { Component, Diagnosis, Rig, Run, RunEvent, RunState, Story } from "../contract/types";
import { late, t } from "../i18n/i18n.svelte";
import { formatSeconds } from "../i18n/quantity";
import { refusalWords } from "../i18n/words";
import { build } from "../loading/build.svelte";
import { connection } from "../loading/connection.svelte";
import { type Bench, CHANNEL_NAMES, type ChannelName } from "../plant/bench";
import { SIGNALS } from "../plant/signals";
import { announcer } from "../shell/announcer.svelte";
import { benches } from "../shell/benches.svelte";
import { rigs } from "../shell/rigs.svelte";
import type { Link, LinkPhase } from "../stream/link";
import type { Hello, ServerMessage } from "../stream/messages";
import { PlayoutClock, playoutDelayS } from "../stream/playout_clock";
import { Slide } from "../stream/slide";
import { Countdown } from "./countdown";
import { FaultCommands, type Injection } from "./fault_commands.svelte";
import { isRecorded } from "./recorded";
import { SampleAge } from "./sample_age";
import { gapSpans } from "./statistics";
import { Stopping } from "./stopping.svelte";
import { isolationAt } from "./story";

const TICK_MS = 200;
const STALE_AFTER_S = 0.5;
/** And not before so many samples should have come. */
const STALE_SAMPLES = 5;
/** 600 s at 1 kHz: more than that no server records. */
const SAMPLES_MAX = 600_000;
/** Room for a run whose length is not known before. */
const SAMPLES_MIN = 2000;
const LAG_MAX_S = 0.5;
/** The beginning of a recording, which tells what it has. */
const TOLD_S = 5;
const NOTHING: Story = { episodes: [], changes: [], change_times_s: [], set_back: false };
/** How often a run is opened again that broke off while it was loaded. */
const OPENED_MAX = 3;

export type Phase = "loading" | "live" | "review" | "missing" | "signed_out" | "failed";

export interface LinkState {
  phase: LinkPhase;
  roundTripS: number | null;
  ageS: number | null;
  gaps: number;
}

/** The run ended while the link was cut: there is no stream any more, only the recording. */
class RunOver extends Error {}

const now = () => performance.now() / 1000;

/**
 * One run on the screen, live or recorded. Samples go socket -> decoder -> slide and never
 * become reactive state; what is shown as text is copied from there five times a second.
 */
export class RunModel {
  phase = $state<Phase>("loading");
  failure = $state("");
  run = $state.raw<Run | null>(null);
  state = $state<RunState>("running");
  events = $state.raw<RunEvent[]>([]);
  verdict = $state.raw<Diagnosis | null>(null);
  nominal = $state.raw<{ swa: number[]; sia: number[] } | null>(null);
  private calibratedDelayS = $state<number | null>(null);
  /** From the converter's edge to the sample of um: of this run, else of its rig, else not known. */
  private readonly delayS = $derived(this.calibratedDelayS ?? this.rig?.capabilities.delta_s);
  link = $state.raw<LinkState>({ phase: "connecting", roundTripS: null, ageS: null, gaps: 0 });
  readonly period = $derived(this.run?.period_s ?? Number.NaN);
  /** What happened in this run and what is known of it: the parts of the page show this. */
  protected whole = $state.raw<Story>(NOTHING);
  /** Events in time order: an alarm is told late. Of each alarm what was named first is one. */
  readonly shownEvents: RunEvent[] = $derived(
    this.events
      .filter((event) => this.tells(event) && !this.isNamedBefore(event))
      .sort((a, b) => a.index - b.index),
  );
  /** Channels of a recording that have values. */
  private readonly recorded = $derived.by(() => {
    const { slide } = this;
    const told = this.phase === "review" ? this.elapsed : Math.min(this.elapsed, TOLD_S);
    if (!this.run || !isRecorded(this.run) || !slide || told === 0) return null;
    const [from, to] = slide.range(0, told);
    const has = (name: ChannelName) =>
      slide.columns[SIGNALS[name].channel]?.subarray(from, to).some(Number.isFinite);
    return CHANNEL_NAMES.filter(has).join();
  });
  /** What is measured in this run: what its rig measures, or what the recording has. */
  readonly measured: ChannelName[] = $derived(
    this.recorded === null
      ? this.bench.channels(this.rig)
      : CHANNEL_NAMES.filter((name) => this.recorded?.split(",").includes(name)),
  );
  /** Run time of the newest sample, five times a second. */
  elapsed = $state(0);
  gaps = $state.raw<[number, number][]>([]);
  slide = $state.raw<Slide | null>(null);

  readonly clock = new PlayoutClock(() => playoutDelayS(this.period));
  private commands = $state.raw<FaultCommands | null>(null);
  private readonly countdown = new Countdown();
  private socket: Link | null = null;
  private age = new SampleAge(0);
  private roundTripS: number | null = null;
  private linkPhase: LinkPhase = "connecting";
  private tick: ReturnType<typeof setInterval> | undefined;
  private refill = false;
  private seenMissing = -1;
  private brokeOff = 0;
  private closed = false;
  readonly stopping = new Stopping(this);

  constructor(readonly id: string) {}

  /** Available when the phase is no longer "loading". */
  get faults(): FaultCommands {
    if (!this.commands) throw new Error("the bench of this run is not known yet");
    return this.commands;
  }

  get bench(): Bench {
    return this.faults.bench;
  }

  /** The rig of this run, if it is still there as the bench that it was. */
  get rig(): Rig | undefined {
    const rig = rigs.find(this.run?.rig);
    return rig?.bench === this.run?.bench ? rig : undefined;
  }

  get duration(): number {
    if (this.phase === "review") return this.elapsed || 1; // it may have ended before its plan
    return this.run?.plan?.duration_s ?? 1;
  }

  get running(): boolean {
    return this.phase === "live" && this.state === "running";
  }

  /** The newest sample is old: the charts do not show the present state of the rig. */
  get stale(): boolean {
    const after = Math.max(STALE_AFTER_S, STALE_SAMPLES * this.period);
    return this.running && (this.link.ageS ?? 0) > after;
  }

  /** The link is open and its samples are late: what is chosen now can wait for it. */
  get falters(): boolean {
    return this.stale && this.faults.canCommand && this.link.phase === "open";
  }

  /** Run time since which the server has not heard the rig; null while it does. */
  get rigSilentFrom(): number | null {
    const last = this.events.findLast((event) => /^rig_(silent|heard)$/.test(event.kind));
    return this.running && last?.kind === "rig_silent" ? this.timeOf(last) : null;
  }

  /** How far the healthy rig is learnt, in seconds of the run; null when it is not being learnt. */
  get learning(): { doneS: number; neededS: number } | null {
    const untilS = this.running ? this.faults.learningUntilS : null;
    if (untilS === null || this.elapsed > untilS) return null;
    const again = this.events.findLast((event) => event.kind === "learning");
    const fromS = again ? this.timeOf(again) : this.bench.about.healthy.from_s;
    const neededS = untilS - fromS;
    return { doneS: Math.min(neededS, Math.max(0, this.elapsed - fromS)), neededS };
  }

  /** Seconds until the end of the calibration; 0 when no change has to wait for it. */
  get learningLeft(): number {
    const until = this.faults.learningUntilS;
    return this.running && until !== null ? Math.max(0, until - this.elapsed) : 0;
  }

  get locked(): boolean {
    return !this.running || !this.faults.canCommand || this.stale || this.link.phase !== "open";
  }

  async open(): Promise<void> {
    this.phase = "loading"; // components that show the old samples release them
    try {
      benches.load().catch(() => {}); // often the bench is in the list
      void rigs.once();
      const stream = build.part(() => import("../stream/run_socket"));
      const run = await api.run(this.id);
      const bench = await benches.need(run.bench);
      this.run = run;
      this.state = run.state;
      this.commands ??= new FaultCommands(bench, (message) => this.socket?.send(message) ?? false);
      this.slide = new Slide(this.sampleCount(), this.period);
      if (this.state !== "running") await this.load();
      else if (!this.closed) this.goLive(await stream);
      this.brokeOff = 0;
    } catch (error) {
      this.fail(error);
    }
  }

  close(): void {
    this.closed = true;
    this.socket?.close();
    clearInterval(this.tick);
    this.commands?.cancelInjection();
  }

  async stop(): Promise<void> {
    this.faults.cancelInjection();
    await this.stopping.press();
  }

  /** Sends the command when the rig's run time reaches `atS`, unless `obstacle` then has a reason. */
  inject(injection: Injection, obstacle: () => string): void {
    const wait = injection.atS - this.clock.rigTime(now()) - (this.roundTripS ?? 0) / 2;
    this.faults.inject(injection, wait, obstacle);
  }

  /**
   * Run time up to which charts are drawn: that of the playout clock, but not beyond the newest
   * sample (a cut link stops the charts) and not far behind it (a simulator may run faster than
   * real time).
   */
  shownTime(nowS: number): number {
    const newest = (this.slide?.end ?? 0) * this.period;
    return Math.min(newest, Math.max(this.clock.time(nowS), newest - LAG_MAX_S, 0));
  }

  /** Run time as this run's samples can tell it: "10.00". */
  seconds(timeS: number): string {
    return formatSeconds(timeS, this.period);
  }

  timeOf(event: RunEvent): number {
    return event.index * this.period;
  }

  private sampleCount(): number {
    const planned = Math.ceil((this.run?.plan?.duration_s ?? 0) / this.period);
    return Math.min(SAMPLES_MAX, Math.max(planned, this.run?.samples ?? 0, SAMPLES_MIN));
  }

  private goLive({ runSocket, socketAddress }: typeof import("../stream/run_socket")): void {
    if (this.closed) return;
    this.phase = "live";
    this.age = new SampleAge(now());
    this.tick = setInterval(() => this.refresh(), TICK_MS);
    let first = true;
    this.socket = runSocket({
      address: async () => {
        if (!first && (await api.run(this.id)).state !== "running") throw new RunOver();
        first = false;
        const { code } = await call("POST /runs/{id}/stream-token", { id: this.id });
        return socketAddress(code);
      },
      nextIndex: () => this.slide?.firstMissing ?? 0,
      isFatal: (error) =>
        error instanceof RunOver ||
        (error instanceof ApiError &&
          error.status >= 400 &&
          error.status < 500 &&
          error.status !== 429),
      events: {
        hello: (message) => this.onHello(message),
        block: (block) => {
          const at = now();
          this.slide?.append(block);
          if (block.serverTime > 0) this.clock.observe(block.serverTime, at);
          this.age.heard(at);
          this.refillGap();
        },
        message: (message) => this.onMessage(message),
        phase: (phase) => {
          if (phase === "waiting" && this.linkPhase === "open") {
            announcer.say("link", t("say_link_lost"));
          }
          this.linkPhase = phase;
          this.refresh();
        },
        roundTrip: (seconds) => {
          this.roundTripS = seconds;
        },
        refused: () => void this.reopen(),
      },
    });
    void this.socket.connect();
  }

  /** Requests samples again that the server dropped because this page was too slow. */
  private refillGap(): void {
    if (!this.refill || (this.slide?.missing ?? 0) === 0) return;
    this.refill = false;
    this.socket?.send({ type: "resume", since: this.slide?.firstMissing ?? 0 });
  }

  private onHello(hello: Hello): void {
    if (hello.state !== "running") {
      this.socket?.close(); // it ended while the stream was opened: no end is told any more
      void this.reopen();
      return;
    }
    this.faults.take(hello);
    this.state = hello.state;
    this.nominal = hello.nominal;
    this.events = hello.events ?? [];
    this.whole = hello.story;
    if (hello.verdict) this.verdict = hello.verdict;
    if (hello.plan && this.run)
      this.run = { ...this.run, plan: { ...this.run.plan, ...hello.plan } };
    announcer.say("link", t("say_connected"));
  }

  private onMessage(message: Exclude<ServerMessage, Hello>): void {
    switch (message.type) {
      case "event":
        if (message.story) this.whole = message.story;
        this.onEvent(message);
        break;
      case "verdict":
        this.verdict = message;
        if (message.story) this.whole = message.story;
        break;
      case "dropped":
        this.refill = true;
        break;
      case "ack":
        this.faults.answered(
          message.id,
          message.ok,
          message.error ? refusalWords(message.error) : "",
        );
        break;
      case "end":
        void this.finish(message.state);
    }
  }

  /** What the page shows of it; an exercise hides some of it, too. */
  get story(): Story {
    return this.whole;
  }

  /** Whether the page tells of this event; an exercise hides some. */
  protected tells(_event: RunEvent): boolean {
    return true;
  }

  private isNamedBefore(event: RunEvent): boolean {
    return event.kind === "isolated" && !isolationAt(this.story, this.timeOf(event));
  }

  private onEvent(event: RunEvent): void {
    this.events = [...this.events, event];
    this.faults.apply(event, this.period);
    if (this.tells(event)) void this.announce(event);
  }

  private async announce(event: RunEvent): Promise<void> {
    const { story } = this;
    const { announcementOf } = await late(() => import("./announcements"));
    const words = announcementOf(event, story, this.bench, this.period);
    if (words) announcer.say(event.kind, words);
  }

  /**
   * The run ended while it was shown: nothing is discarded, and the page changes to review. What the
   * stream did not bring before its end (it was opened just then, or a gap was open) is loaded.
   */
  private async finish(state: RunState): Promise<void> {
    // a server that goes away ends the stream too: until it answers, the link is cut
    const ended = await api.run(this.id).catch(() => undefined);
    if (ended && this.slide && this.slide.firstMissing < ended.samples)
      await this.loadSamples(this.slide);
    this.state = state;
    clearInterval(this.tick);
    this.faults.cancelInjection();
    this.refresh();
    this.standStill();
    await this.loadResults();
    if (ended?.events) this.faults.review(ended.events, this.period);
    this.phase = "review";
    announcer.say("end", t("say_finished"));
  }

  /** Loads a run that had already ended when the page was opened. */
  private async load(): Promise<void> {
    const slide = this.slide as Slide;
    this.events = this.run?.events ?? [];
    this.whole = this.run?.story ?? NOTHING;
    await Promise.all([this.loadSamples(slide), this.loadResults()]);
    this.standStill();
    this.gaps = gapSpans(slide);
    this.faults.review(this.events, this.period);
    this.phase = "review";
  }

  private async loadSamples(slide: Slide): Promise<void> {
    const [frames, { readFrames }] = await Promise.all([
      api.frames(this.id),
      build.part(() => import("../stream/frame_reader")),
    ]);
    await readFrames(frames, (block) => slide.append(block));
  }

  private standStill(): void {
    const end = (this.slide?.end ?? 0) * this.period;
    this.clock.freeze(end);
    this.elapsed = end;
  }

  /**
   * Loads the server's results for the whole run. A failure is shown, and the user can try
   * again.
   */
  async loadResults(): Promise<void> {
    this.failure = "";
    try {
      const [known, diagnosis] = await Promise.all([api.run(this.id), api.diagnosis(this.id)]);
      // what a crash had cut has been diagnosed by that
      const run = known.verdict ? known : await api.run(this.id);
      this.run = run;
      this.whole = run.story ?? NOTHING;
      this.state = run.state;
      this.verdict = diagnosis;
      if (!this.nominal) void this.learnNominal(diagnosis.calibration?.delta_s);
      if (run.events && run.events.length >= this.events.length) this.events = run.events;
    } catch (error) {
      // a run that was interrupted early has no diagnosis, which is not a failure
      if (!(error instanceof ApiError)) this.failure = t("server_away");
    }
  }

  /** The estimators' values on this bench, sampled as in this run: nominal, or with a fault. */
  model(component?: Component, value?: number) {
    const sampled = { bench: this.bench.id, period_s: this.period, delta_s: this.delayS };
    return call("GET /benches/{bench}/model", { ...sampled, component, value });
  }

  /** Loads the nominal parameters for a recorded run, sampled with the delay of its rig. */
  private async learnNominal(delayS: number | null | undefined): Promise<void> {
    try {
      if (typeof delayS === "number") this.calibratedDelayS = delayS;
      else await rigs.once();
      this.nominal = await this.model();
    } catch {
      // the charts then have no nominal line
    }
  }

  private async reopen(): Promise<void> {
    clearInterval(this.tick);
    await this.open();
  }

  private refresh(): void {
    const slide = this.slide;
    if (!slide) return;
    const at = now();
    const agedS = this.age.at(at);
    this.elapsed = slide.end * this.period;
    const ageS = this.phase === "live" ? agedS : null;
    this.link = {
      phase: this.linkPhase,
      roundTripS: this.roundTripS,
      ageS,
      gaps: slide.missing,
    };
    if (slide.missing !== this.seenMissing) {
      this.seenMissing = slide.missing;
      this.gaps = gapSpans(slide);
    }
    this.countdown.at(
      this.elapsed,
      this.bench,
      this.run?.plan?.faults ?? [],
      this.faults.injection,
    );
  }

  private fail(error: unknown): void {
    if (error instanceof ApiError) {
      const phases: Record<number, Phase> = { 401: "signed_out", 404: "missing" };
      this.phase = phases[error.status] ?? "failed";
      this.failure = error.message;
    } else if (this.brokeOff++ < OPENED_MAX) {
      void connection.again().then(() => this.open());
    } else {
      this.phase = "failed";
      this.failure = t("server_away");
    }
  }
}
