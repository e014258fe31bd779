import { untrack } from "svelte";
import type { Catalogue, Key } from "./catalogue";
import { en } from "./en";

export type Locale = "en" | "sr-Latn" | "sr-Cyrl";
export const LOCALES: Record<Locale, string> = {
  en: "English",
  "sr-Latn": "Srpski",
  "sr-Cyrl": "Српски",
};
const KEY = "faultlab.locale";

export async function loadCatalogue(locale: Locale): Promise<Catalogue> {
  if (locale === "en") return { ...en, ...(await import("./en_more")).enMore };
  const [{ srLatn }, { refusalsSr }, { toCyrillic }] = await Promise.all([
    import("./sr_latn"),
    import("./refusals_sr"),
    import("./cyrillic"),
  ]);
  const script = locale === "sr-Cyrl" ? toCyrillic : (text: string) => text;
  // `back ticks` in the catalogue exclude words from the change of script
  return Object.fromEntries(
    Object.entries({ ...srLatn, ...refusalsSr }).map(([key, text]) => [
      key,
      script(text).replaceAll("`", ""),
    ]),
  ) as Catalogue;
}

class I18n {
  locale = $state<Locale>("en");
  private catalogue = $state.raw<Partial<Catalogue>>(en);

  async start(): Promise<void> {
    const stored = localStorage.getItem(KEY);
    if (stored && stored in LOCALES) await this.set(stored as Locale);
  }

  async set(locale: Locale): Promise<void> {
    this.catalogue = await loadCatalogue(locale);
    this.locale = locale;
    localStorage.setItem(KEY, locale);
    document.documentElement.lang = locale;
  }

  /** Loads the texts of all pages; in a language other than English they are already complete. */
  async loadAll(): Promise<void> {
    if (untrack(() => this.locale) === "en") this.catalogue = await loadCatalogue("en");
  }

  /** Locale for dates and times: 24 hours and day before month, also in English. */
  get dates(): string {
    return this.locale === "en" ? "en-GB" : this.locale;
  }

  has(key: string): boolean {
    return key in this.catalogue;
  }

  text(key: Key): string {
    return this.catalogue[key] ?? "";
  }
}

export const i18n = new I18n();

/** Loads a part of the page together with the texts that it needs. */
export async function late<T>(load: () => Promise<T>): Promise<T> {
  const [part] = await Promise.all([load(), i18n.loadAll()]);
  return part;
}

/** The text of `key` in the current language, with {name} replaced. */
export function t(key: Key, values: Record<string, string | number> = {}): string {
  return fill(i18n.text(key), values);
}

export function fill(text: string, values: Record<string, string | number>): string {
  return text.replace(/\{(\w+)\}/g, (whole, name: string) => String(values[name] ?? whole));
}
