import { onMount } from "svelte";
import { wordsOf } from "../i18n/words";

/** What has no answer for so long holds back nothing that stands below it. */
const AWAITED_MAX_MS = 10_000;

/**
 * Runs actions that may be refused, keeps the refusal for the page to show, and reloads the
 * data.
 */
export class Attempts {
  busy = $state(false);
  loaded = $state(false);
  /** Neither data nor a failure has come yet, and that is not unusual. */
  awaited = $state(true);
  /** Of the last action; it stays said while the data are fetched again. */
  private refused = $state("");
  /** Why the data are not here, or not the newest. */
  private unanswered = $state("");

  /** @param load  fetches what the page shows */
  constructor(private readonly load: () => Promise<unknown> = async () => {}) {}

  get failure(): string {
    return this.refused || this.unanswered;
  }

  async start(): Promise<void> {
    this.refused = "";
    setTimeout(() => {
      this.awaited = false;
    }, AWAITED_MAX_MS);
    this.loaded = await this.fetch();
    this.awaited = false;
  }

  /**
   * Runs an action and reloads, also after a refusal, which often means that the page was out of
   * date. A field that was sent is emptied by the action: after the reload somebody may be typing.
   */
  async act(action: () => Promise<unknown>): Promise<boolean> {
    const done = await this.run(action);
    await this.fetch();
    return done;
  }

  async run(action: () => Promise<unknown>): Promise<boolean> {
    this.refused = await this.trouble(action);
    return this.refused === "";
  }

  /**
   * Starts, and fetches again from then on, also when an answer has failed to come.
   * @param wanted  whether it may now
   * @returns ends it
   */
  keepFresh(everyMs: number, wanted: () => boolean = () => true): () => void {
    void this.start();
    const timer = setInterval(() => {
      if (!this.busy && wanted()) void this.again();
    }, everyMs);
    return () => clearInterval(timer);
  }

  private async again(): Promise<void> {
    if (await this.fetch()) this.loaded = true;
  }

  private async fetch(): Promise<boolean> {
    this.unanswered = await this.trouble(this.load);
    return this.unanswered === "";
  }

  private async trouble(action: () => Promise<unknown>): Promise<string> {
    this.busy = true;
    try {
      await action();
      return "";
    } catch (error) {
      return wordsOf(error);
    } finally {
      this.busy = false;
    }
  }
}

/** They start when the component is there that makes them. */
export function onceHere(load: () => Promise<unknown>): Attempts {
  const attempts = new Attempts(load);
  onMount(() => void attempts.start());
  return attempts;
}
