/** Runs what may be refused, and keeps the refusal for the page to show. */
export class Attempts {
  failure = $state("");
  busy = $state(false);

  async run(action: () => Promise<unknown>): Promise<boolean> {
    this.busy = true;
    try {
      await action();
      this.failure = "";
      return true;
    } catch (error) {
      this.failure = error instanceof Error ? error.message : String(error);
      return false;
    } finally {
      this.busy = false;
    }
  }
}
