import { connection } from "./connection.svelte";

const KEY = "faultlab.reloaded";
/** A part that takes longer may wait for a server that is away: the page asks, and says so. */
const SLOW_MS = 2000;
const TYPED = "textarea, input:not([type=range], [type=checkbox], [type=radio])";
/** Names this build: the name of the page's first script contains a hash of its content. */
const entry = () => document.querySelector<HTMLScriptElement>("script[type=module]")?.src ?? "";

/**
 * Loads the page's parts. A part that did not come is asked for again when the server answers. If
 * it does not come then either, the server has another build, or the browser keeps the failure:
 * the page is loaded anew, once for each build, when nobody loses anything by it.
 */
class Build {
  /** A part is missing until the page is loaded anew. */
  incomplete = $state(false);
  /** What would be lost: text that somebody has typed, a change that is armed. */
  private readonly held = new Set<unknown>();

  constructor() {
    globalThis.document?.addEventListener("input", ({ target }) => {
      if (target instanceof Element && target.matches(TYPED)) this.held.add(target);
    });
    globalThis.document?.addEventListener("submit", ({ target }) => {
      for (const each of this.held) {
        if (each instanceof Node && (target as Node).contains(each)) this.held.delete(each);
      }
    });
  }

  /** While `what` is held, the page is not loaded anew by itself. */
  hold(what: unknown, on: boolean): void {
    if (on) this.held.add(what);
    else this.held.delete(what);
  }

  async part<T>(load: () => Promise<T>): Promise<T> {
    const slow = setTimeout(() => void connection.check(), SLOW_MS);
    try {
      return await load();
    } catch {
      await connection.again();
      await againStyles();
      try {
        return await load();
      } catch (error) {
        this.incomplete = true;
        console.error(error);
        if (this.mayReload()) {
          sessionStorage.setItem(KEY, entry());
          this.reload();
        }
        return new Promise(() => {}); // the part is missing until then, and the page says so
      }
    } finally {
      clearTimeout(slow);
    }
  }

  reload(): void {
    location.reload();
  }

  private mayReload(): boolean {
    const typed = [...this.held].some((each) => !(each instanceof Node) || each.isConnected);
    return !typed && sessionStorage.getItem(KEY) !== entry();
  }
}

/** A style sheet that did not come is not asked for again by the import of its part. */
async function againStyles(): Promise<void> {
  const links = [...document.querySelectorAll<HTMLLinkElement>("link[rel=stylesheet]")];
  await Promise.all(
    links
      .filter((link) => !link.sheet)
      .map(
        (link) =>
          new Promise((done) => {
            const fresh = link.cloneNode() as HTMLLinkElement;
            fresh.onload = fresh.onerror = done;
            link.replaceWith(fresh);
          }),
      ),
  );
}

export const build = new Build();
