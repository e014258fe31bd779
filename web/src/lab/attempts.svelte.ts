import { wordsOf } from "../i18n/words";
/**
 * Runs actions that may be refused, keeps the refusal for the page to show, and reloads the
 * data.
 */
export class Attempts {
  failure = $state("");
  busy = $state(false);
  loaded = $state(false);

  /** @param load  fetches what the page shows */
  constructor(private readonly load: () => Promise<unknown> = async () => {}) {}

  async start(): Promise<void> {
    this.loaded = await this.run(this.load);
  }

  /**
   * Runs an action and reloads, also after a refusal, which often means that the page was out of
   * date. A field that was sent is emptied by the action: after the reload somebody may be typing.
   */
  async act(action: () => Promise<unknown>): Promise<boolean> {
    const done = await this.run(action);
    const refusal = this.failure;
    await this.run(this.load);
    if (!done) this.failure = refusal;
    return done;
  }

  async run(action: () => Promise<unknown>): Promise<boolean> {
    this.busy = true;
    try {
      await action();
      this.failure = "";
      return true;
    } catch (error) {
      this.failure = wordsOf(error);
      return false;
    } finally {
      this.busy = false;
    }
  }
}
