import { flushSync } from "svelte";
import { build } from "../loading/build.svelte";
import { dark, light, type Tokens } from "./tokens";

export type ThemeChoice = "auto" | "light" | "dark";
const KEY = "faultlab.theme";

function stored(): ThemeChoice {
  const value = localStorage.getItem(KEY);
  return value === "light" || value === "dark" ? value : "auto";
}

/** The current theme; the page and the charts take their colours from `tokens`. */
class Theme {
  choice = $state<ThemeChoice>("auto");
  private systemDark = $state(false);
  /** The system's colours replace the page's: charts and drawings must fit them. */
  private forced = $state(false);
  private printing = $state(false);

  get dark(): boolean {
    if (this.printing) return false;
    return this.choice === "auto" || this.forced ? this.systemDark : this.choice === "dark";
  }

  get tokens(): Tokens {
    return this.dark ? dark : light;
  }

  start(): void {
    this.choice = stored();
    const query = matchMedia("(prefers-color-scheme: dark)");
    this.systemDark = query.matches;
    query.addEventListener("change", (event) => {
      this.systemDark = event.matches;
    });
    const forced = matchMedia("(forced-colors: active)");
    const follow = () => {
      this.forced = forced.matches;
      if (this.forced) void build.part(() => import("./forced.css"));
    };
    follow();
    forced.addEventListener("change", follow);
    addEventListener("beforeprint", () => this.print(true));
    addEventListener("afterprint", () => this.print(false));
    this.apply();
  }

  set(choice: ThemeChoice): void {
    this.choice = choice;
    localStorage.setItem(KEY, choice);
  }

  /** Sets the custom properties through the CSSOM, which a strict CSP allows. */
  apply(): void {
    const root = document.documentElement;
    root.style.setProperty("color-scheme", this.dark ? "dark" : "light");
    for (const [name, value] of Object.entries(this.tokens)) {
      root.style.setProperty(`--${name}`, value);
    }
  }

  /** Printed pages use the light theme. */
  private print(on: boolean): void {
    this.printing = on;
    flushSync();
    this.apply();
  }
}

export const theme = new Theme();
