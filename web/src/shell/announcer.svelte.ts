const PAUSE_MS = 2000;

/**
 * Messages for screen readers: one polite region, at most one message in 2 s. Messages that come
 * sooner wait; a new message replaces a waiting one of the same kind.
 */
export class Announcer {
  message = $state("");
  private waiting: { kind: string; text: string }[] = [];
  private timer: ReturnType<typeof setTimeout> | undefined;

  say(kind: string, text: string): void {
    this.waiting = this.waiting.filter((entry) => entry.kind !== kind);
    this.waiting.push({ kind, text });
    if (this.timer === undefined) this.next();
  }

  private next(): void {
    const entry = this.waiting.shift();
    if (!entry) {
      this.timer = undefined;
      return;
    }
    this.message = entry.text;
    this.timer = setTimeout(() => this.next(), PAUSE_MS);
  }
}

export const announcer = new Announcer();
