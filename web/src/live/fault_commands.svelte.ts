import type { Component, RunEvent } from "../contract/types";
import { build } from "../loading/build.svelte";
import type { Bench } from "../plant/bench";
import { announcer } from "../shell/announcer.svelte";
import type { ClientMessage, Hello } from "../stream/messages";
import {
  applied,
  asked,
  faultyComponents,
  refused,
  type Settings,
  settingsFrom,
  unrefused,
  type Waiting,
  waitingAfter,
  withWaiting,
} from "./positions";

export interface Injection {
  component: Component;
  value: number;
  atS: number;
}

/** Sends a message to the rig; false when there is no link. */
export type SendToRig = (message: ClientMessage) => boolean;

/**
 * The requests of this page to the rig, and the rig's answers. A setting is "commanded" from the
 * request on and "confirmed" only by the rig's event; each command carries the epoch of the
 * lease. A change before the end of the calibration waits in the server, and the server reports
 * this.
 */
export class FaultCommands {
  settings = $state.raw<Settings>({});
  /** Changes that wait in the server, and the run time until which they wait. */
  waiting = $state.raw<Waiting>({});
  learningUntilS = $state<number | null>(null);
  readonly shown: Settings;
  canCommand = $state(false);
  /** The server has reported that another user commands this rig. */
  watching = $state(false);
  injection = $state<Injection | null>(null);
  /** Why the newest command without a component (all nominal) was refused. */
  refusal = $state("");
  private readonly obstacles = new Map<Component, () => string>();
  private epoch = 0;
  private nextId = 1;
  private readonly sent = new Map<number, Component | null>();
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    readonly bench: Bench,
    private readonly send: SendToRig,
  ) {
    this.shown = $derived(withWaiting(this.bench, this.settings, this.waiting));
  }

  /** The stream was (re)opened: the state reported by the rig replaces the state here. */
  take(hello: Hello): void {
    this.epoch = hello.epoch;
    this.canCommand = hello.can_command;
    this.watching = !hello.can_command;
    this.settings = settingsFrom(this.bench, hello.positions ?? {});
    this.waiting = hello.waiting ?? {};
    this.learningUntilS = hello.learning_until_s ?? null;
    this.sent.clear();
    this.refusal = "";
  }

  apply(event: RunEvent, period: number): void {
    if (event.kind === "learning") this.learningUntilS = event.value ?? null;
    this.settings = applied(this.bench, this.settings, event, period);
    this.waiting = waitingAfter(this.waiting, event);
  }

  /** The run is over: what its events say, however late the stream was opened. */
  review(events: readonly RunEvent[], period: number): void {
    this.settings = {};
    this.waiting = {};
    for (const event of events) this.apply(event, period);
  }

  set(component: Component, value: number): void {
    if (this.command("set", component, value)) {
      this.settings = asked(this.bench, this.settings, component, value);
    }
  }

  allNominal(): void {
    this.cancelInjection();
    if (!this.command("nominal")) return;
    for (const component of faultyComponents(this.bench, this.settings)) {
      this.settings = asked(this.bench, this.settings, component, this.bench.nominal(component));
    }
  }

  stop(): boolean {
    return this.command("stop");
  }

  /** @param obstacle  what refuses it here, in this page, as long as it has words */
  refuse(component: Component, reason: string, obstacle?: () => string): void {
    if (obstacle) this.obstacles.set(component, obstacle);
    else this.obstacles.delete(component);
    this.settings = refused(this.bench, this.settings, component, reason);
    announcer.say("refused", reason);
  }

  /** Takes back the refusals whose obstacle is gone. */
  reconsider(): void {
    for (const [component, obstacle] of this.obstacles) {
      if (obstacle()) continue;
      this.obstacles.delete(component);
      this.settings = unrefused(this.bench, this.settings, component);
    }
  }

  answered(id: number, ok: boolean, reason: string): void {
    const component = this.sent.get(id);
    this.sent.delete(id);
    if (ok) {
      this.refusal = "";
    } else if (component) {
      this.refuse(component, reason);
    } else if (component === null) {
      this.refusal = reason;
      announcer.say("refused", reason);
    }
  }

  /** Sends the setting after `waitS` seconds, or refuses it for the reason that `obstacle` has then. */
  inject(injection: Injection, waitS: number, obstacle: () => string = () => ""): void {
    this.cancelInjection();
    this.injection = injection;
    build.hold(this, true); // it is armed here, in this page
    this.timer = setTimeout(
      () => {
        this.injection = null;
        build.hold(this, false);
        const reason = obstacle();
        if (reason) this.refuse(injection.component, reason, obstacle);
        else this.set(injection.component, injection.value);
      },
      Math.max(0, waitS * 1000),
    );
  }

  cancelInjection(): void {
    clearTimeout(this.timer);
    this.injection = null;
    build.hold(this, false);
  }

  private command(
    action: "set" | "nominal" | "stop",
    component?: Component,
    value?: number,
  ): boolean {
    const id = this.nextId++;
    const sent = this.send({ type: "command", epoch: this.epoch, id, action, component, value });
    if (sent) this.sent.set(id, component ?? null);
    return sent;
  }
}
