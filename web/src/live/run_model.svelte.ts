import { ApiError, api } from "../api/client";
import type { Component, Diagnosis, Run, RunEvent, RunState } from "../api/types";
import { t } from "../i18n/i18n.svelte";
import { NOMINAL } from "../plant/components";
import { continuousModel, discreteModel } from "../plant/model";
import { formatQuantity } from "../plant/quantity";
import { announcer } from "../shell/announcer.svelte";
import { readFrames } from "../stream/frame_reader";
import type { Hello, Readout, ServerMessage } from "../stream/messages";
import { PlayoutClock } from "../stream/playout_clock";
import { type LinkPhase, RunSocket } from "../stream/run_socket";
import { Slide } from "../stream/slide";
import { announcementOf } from "./announcements";
import {
  applied,
  asked,
  faultyComponents,
  refused,
  type Settings,
  settingsFrom,
} from "./positions";
import { gapSpans } from "./statistics";

const TICK_MS = 200;
const STALE_AFTER_S = 0.5;
const SAMPLES_MAX = 60_000;
const COUNTDOWN_S = 3;
const BENCH_DELAY_S = 0.0095;
const LAG_MAX_S = 0.5;

export type Phase = "loading" | "live" | "review" | "missing" | "failed";

export interface LinkState {
  phase: LinkPhase;
  roundTripS: number | null;
  ageS: number | null;
  gaps: number;
}

export interface Injection {
  component: Component;
  value: number;
  atS: number;
}

/** The nominal parameters of a recorded run: Eq. 4, sampled with the delay that the rig showed. */
function nominalFor(delayS: number | null | undefined, period: number) {
  const { b0, b1, a1 } = continuousModel();
  const { b0d, b1d, a1d } = discreteModel({ b0, b1, a1 }, period, delayS ?? BENCH_DELAY_S);
  return { swa: [b0d, b1d, a1d], sia: [b0, b1, a1] };
}

const now = () => performance.now() / 1000;

/**
 * One run on the screen, live or recorded. Samples go socket -> decoder -> slide and never touch
 * reactive state; what the page's text shows is copied from there five times a second.
 */
export class RunModel {
  phase = $state<Phase>("loading");
  failure = $state("");
  run = $state.raw<Run | null>(null);
  state = $state<RunState>("running");
  events = $state.raw<RunEvent[]>([]);
  verdict = $state.raw<Diagnosis | null>(null);
  readouts = $state.raw<Readout[]>([]);
  nominal = $state.raw<{ swa: number[]; sia: number[] } | null>(null);
  settings = $state.raw<Settings>({});
  canCommand = $state(false);
  link = $state.raw<LinkState>({ phase: "connecting", roundTripS: null, ageS: null, gaps: 0 });
  /** Run time of the newest sample, five times a second. */
  elapsed = $state(0);
  gaps = $state.raw<[number, number][]>([]);
  injection = $state<Injection | null>(null);
  slide = $state.raw<Slide | null>(null);

  readonly clock = new PlayoutClock();
  private socket: RunSocket | null = null;
  private epoch = 0;
  private nextCommand = 1;
  private readonly sent = new Map<number, Component>();
  private lastBlockAt = 0;
  private roundTripS: number | null = null;
  private linkPhase: LinkPhase = "connecting";
  private tick: ReturnType<typeof setInterval> | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private refill = false;
  private seenMissing = -1;
  private countedDown = new Set<string>();

  constructor(readonly id: string) {}

  get period(): number {
    return this.run?.plan?.period_s ?? this.run?.period_s ?? 0.01;
  }

  get duration(): number {
    const samples = this.phase === "review" ? (this.run?.samples ?? 0) * this.period : 0;
    return this.run?.plan?.duration_s ?? (samples || 20);
  }

  get running(): boolean {
    return this.phase === "live" && this.state === "running";
  }

  /** The newest sample is old: what the charts show is not what the rig does. */
  get stale(): boolean {
    return this.running && (this.link.ageS ?? 0) > STALE_AFTER_S;
  }

  get locked(): boolean {
    return !this.running || !this.canCommand || this.stale || this.link.phase !== "open";
  }

  async open(): Promise<void> {
    try {
      this.run = await api.run(this.id);
      this.state = this.run.state;
      this.slide = new Slide(this.sampleCount(), this.period);
      if (this.state === "running" || this.state === "queued") this.goLive();
      else await this.load();
    } catch (error) {
      this.fail(error);
    }
  }

  close(): void {
    this.socket?.close();
    clearInterval(this.tick);
    clearTimeout(this.timer);
  }

  async stop(): Promise<void> {
    this.cancelInjection();
    try {
      await api.stopRun(this.id);
    } catch (error) {
      if (!this.command("stop")) throw error;
    }
  }

  set(component: Component, value: number): void {
    if (this.command("set", component, value)) {
      this.settings = asked(this.settings, component, value);
    }
  }

  allNominal(): void {
    this.cancelInjection();
    if (!this.command("nominal")) return;
    for (const component of faultyComponents(this.settings)) {
      this.settings = asked(this.settings, component, NOMINAL[component]);
    }
  }

  refuse(component: Component, reason: string): void {
    this.settings = refused(this.settings, component, reason);
    announcer.say("refused", reason);
  }

  /** Sends the command when the rig's clock reaches `atS`. */
  inject(injection: Injection): void {
    this.cancelInjection();
    const wait = injection.atS - this.clock.rigTime(now()) - (this.roundTripS ?? 0) / 2;
    this.injection = injection;
    this.timer = setTimeout(
      () => {
        this.injection = null;
        this.set(injection.component, injection.value);
      },
      Math.max(0, wait * 1000),
    );
  }

  cancelInjection(): void {
    clearTimeout(this.timer);
    this.injection = null;
  }

  /**
   * Run time to draw up to: the playout clock's, but never beyond the newest sample (a cut link
   * freezes the charts) nor far behind it (a simulator may run faster than time).
   */
  shownTime(nowS: number): number {
    const newest = (this.slide?.end ?? 0) * this.period;
    return Math.min(newest, Math.max(this.clock.time(nowS), newest - LAG_MAX_S, 0));
  }

  timeOf(event: RunEvent): number {
    return event.index * this.period;
  }

  private sampleCount(): number {
    const planned = Math.ceil((this.run?.plan?.duration_s ?? 0) / this.period);
    return Math.min(SAMPLES_MAX, Math.max(planned, this.run?.samples ?? 0, 2000));
  }

  private goLive(): void {
    this.phase = "live";
    this.lastBlockAt = now();
    this.tick = setInterval(() => this.refresh(), TICK_MS);
    this.socket = new RunSocket({
      address: async () => {
        const { code } = await api.streamToken(this.id);
        const scheme = location.protocol === "https:" ? "wss" : "ws";
        return `${scheme}://${location.host}/ws?code=${encodeURIComponent(code)}`;
      },
      nextIndex: () => this.firstMissing(),
      isFatal: (error) => error instanceof ApiError && error.status >= 400 && error.status < 500,
      events: {
        hello: (message) => this.onHello(message),
        block: (block) => {
          const at = now();
          this.slide?.append(block);
          if (block.serverTime > 0) this.clock.observe(block.serverTime, at);
          this.lastBlockAt = at;
          this.refillGap();
        },
        message: (message) => this.onMessage(message),
        phase: (phase) => {
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

  /** Asks again for samples that the server dropped because this page was too slow for them. */
  private refillGap(): void {
    if (!this.refill || (this.slide?.missing ?? 0) === 0) return;
    this.refill = false;
    this.socket?.send({ type: "resume", since: this.firstMissing() });
  }

  /** Where to resume: the first sample that is not here. */
  private firstMissing(): number {
    const slide = this.slide;
    if (!slide) return 0;
    if (slide.missing === 0) return slide.end;
    for (let index = slide.first; index < slide.end; index++) {
      if (slide.isMissing(slide.slot(index))) return index;
    }
    return slide.end;
  }

  private onHello(hello: Hello): void {
    this.epoch = hello.epoch;
    this.state = hello.state;
    this.nominal = hello.nominal;
    this.canCommand = hello.can_command;
    this.events = hello.events ?? [];
    if (hello.verdict) this.verdict = hello.verdict;
    this.settings = settingsFrom(hello.positions ?? {});
    if (hello.plan && this.run)
      this.run = { ...this.run, plan: { ...this.run.plan, ...hello.plan } };
    announcer.say("link", t("say_connected"));
  }

  private onMessage(message: Exclude<ServerMessage, Hello>): void {
    switch (message.type) {
      case "event":
        this.onEvent(message);
        break;
      case "verdict":
        this.verdict = message;
        break;
      case "readout":
        this.readouts = message.estimators;
        break;
      case "dropped":
        this.refill = true;
        break;
      case "ack":
        this.onAck(message.id, message.ok, message.error?.message ?? "");
        break;
      case "end":
        this.state = message.state;
        void this.finish();
        break;
      default:
        break;
    }
  }

  private onEvent(event: RunEvent): void {
    this.events = [...this.events, event];
    this.settings = applied(this.settings, event, this.period);
    const words = announcementOf(event, this.verdict, this.period);
    if (words) announcer.say(event.kind, words);
  }

  private onAck(id: number, ok: boolean, reason: string): void {
    const component = this.sent.get(id);
    this.sent.delete(id);
    if (!ok && component) this.refuse(component, reason);
  }

  private command(
    action: "set" | "nominal" | "stop",
    component?: Component,
    value?: number,
  ): boolean {
    const id = this.nextCommand++;
    const epoch = this.epoch;
    const sent =
      this.socket?.send({ type: "command", epoch, id, action, component, value }) ?? false;
    if (sent && component) this.sent.set(id, component);
    return sent;
  }

  /** The run ended while we watched: nothing is thrown away, the page turns to review. */
  private async finish(): Promise<void> {
    clearInterval(this.tick);
    this.cancelInjection();
    this.refresh();
    const end = (this.slide?.end ?? 0) * this.period;
    this.clock.freeze(end);
    this.elapsed = end;
    this.phase = "review";
    announcer.say("end", t("say_finished"));
    await this.loadResults();
  }

  /** A run that was over when the page came. */
  private async load(): Promise<void> {
    const slide = this.slide as Slide;
    this.events = this.run?.events ?? [];
    if (this.run?.verdict && typeof this.run.verdict === "object") this.verdict = this.run.verdict;
    await readFrames(await api.frames(this.id), (block) => slide.append(block));
    const end = slide.end * this.period;
    this.clock.freeze(end);
    this.elapsed = end;
    this.gaps = gapSpans(slide);
    for (const event of this.events) this.settings = applied(this.settings, event, this.period);
    this.phase = "review";
    await this.loadResults();
  }

  private async loadResults(): Promise<void> {
    try {
      const [run, diagnosis] = await Promise.all([api.run(this.id), api.diagnosis(this.id)]);
      this.run = run;
      this.state = run.state;
      this.verdict = diagnosis;
      this.nominal ??= nominalFor(diagnosis.calibration?.delta_s, this.period);
      if (run.events && run.events.length >= this.events.length) this.events = run.events;
    } catch (error) {
      if (!(error instanceof ApiError)) throw error; // no diagnosis of an interrupted run
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
    this.elapsed = slide.end * this.period;
    const ageS = this.phase === "live" ? at - this.lastBlockAt : null;
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
    this.countDown();
  }

  /** Says once, three seconds before, that a planned fault is coming. */
  private countDown(): void {
    const planned = (this.run?.plan?.faults ?? []).map((fault) => ({ ...fault, atS: fault.at_s }));
    for (const fault of this.injection ? [...planned, this.injection] : planned) {
      const left = fault.atS - this.elapsed;
      const key = `${fault.component}@${fault.atS}`;
      if (left <= 0 || left > COUNTDOWN_S || this.countedDown.has(key)) continue;
      this.countedDown.add(key);
      const value = formatQuantity(fault.component, fault.value);
      announcer.say("countdown", t("say_countdown", { component: fault.component, value }));
    }
  }

  private fail(error: unknown): void {
    this.phase = error instanceof ApiError && error.status === 404 ? "missing" : "failed";
    this.failure = error instanceof Error ? error.message : String(error);
  }
}
