import { build } from "../loading/build.svelte";

/** Whether an address is a page of this site, not another site and not an address that acts. */
export const isPage = (url: Pick<URL, "origin" | "pathname">): boolean =>
  url.origin === location.origin && /^\/(?!api\/|metrics(\/|$))([\w-]+(\/|$)|$)/.test(url.pathname);

/** The address of the page: a path, observed by the components. History API, no library. */
class Router {
  path = $state(location.pathname);
  query = $state(new URLSearchParams(location.search));

  start(): void {
    addEventListener("popstate", () => this.read());
    document.addEventListener("click", (event) => {
      if (event.defaultPrevented || event.button !== 0) return;
      if (event.metaKey || event.ctrlKey || event.shiftKey || event.altKey) return;
      const anchor = (event.target as Element | null)?.closest?.("a[href]");
      if (!(anchor instanceof HTMLAnchorElement)) return;
      if (anchor.target || anchor.hasAttribute("download")) return;
      if (!isPage(anchor)) return;
      if (anchor.hash && anchor.pathname === location.pathname) return;
      event.preventDefault();
      this.go(anchor.pathname + anchor.search);
    });
  }

  go(path: string, replace = false): void {
    if (build.incomplete) {
      location.assign(path); // brings the new build
      return;
    }
    if (replace) history.replaceState(null, "", path);
    else history.pushState(null, "", path);
    this.read();
    scrollTo(0, 0);
  }

  private read(): void {
    this.path = location.pathname;
    this.query = new URLSearchParams(location.search);
  }
}

export const router = new Router();
