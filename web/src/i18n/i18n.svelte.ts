import { untrack } from "svelte";
import { build } from "../loading/build.svelte";
import { busyDuring } from "../loading/busy";
import type { Catalogue, Key, Text } from "./catalogue";
import { texts as first } from "./languages/en.ts?first";

/** By BCP 47 tag, which is the name of its file in languages/; the file has all its texts. */
export type Locale = string;

const files = import.meta.glob<{ texts: Catalogue }>(["./languages/*.ts", "!./languages/en.ts"]);
const fileOf = (locale: Locale) => files[`./languages/${locale}.ts`];
const tags = Object.keys(files).map((file) => file.replace(/^.*\/|\.ts$/g, ""));

/** What the language calls itself, without "(latinica)": its letters show that. */
function ownName(locale: Locale): string {
  const name = new Intl.DisplayNames([locale], { type: "language" }).of(locale) ?? locale;
  return name.charAt(0).toLocaleUpperCase(locale) + name.slice(1).replace(/ \(.*\)$/, "");
}
/** The languages of this page, each with its own name. */
export const LOCALES: readonly { locale: Locale; name: string }[] = [
  "en",
  ...tags.sort().reverse(),
].map((locale) => ({ locale, name: ownName(locale) }));
const KEY = "faultlab.locale";

/** What of English is loaded later. */
const later = {
  rest: () => import("./languages/en.ts?rest"),
  lessons: () => import("./languages/en.ts?lessons"),
};
type Later = keyof typeof later;

export async function loadCatalogue(locale: Locale): Promise<Catalogue> {
  const load = fileOf(locale);
  if (load) return (await load()).texts;
  const [rest, lessons] = await Promise.all([later.rest(), later.lessons()]);
  return { ...first, ...rest.texts, ...lessons.texts };
}

class I18n {
  locale = $state<Locale>("en");
  private catalogue = $state.raw<Partial<Catalogue>>(first);
  private readonly loaded = new Set<Later>();
  private readonly plurals = $derived(new Intl.PluralRules(this.locale));
  private readonly numbers = new Map<string, Intl.NumberFormat>();

  async start(): Promise<void> {
    const stored = localStorage.getItem(KEY);
    if (stored && fileOf(stored)) await this.set(stored);
  }

  async set(locale: Locale): Promise<void> {
    this.catalogue = await build.part(() => loadCatalogue(locale));
    for (const part of Object.keys(later) as Later[]) this.loaded.add(part);
    this.locale = locale;
    localStorage.setItem(KEY, locale);
    document.documentElement.lang = locale;
  }

  /** Loads the texts of all pages; in a language other than English they are already complete. */
  async loadAll(part: Later = "rest"): Promise<void> {
    const missing = () => untrack(() => this.locale) === "en" && !this.loaded.has(part);
    if (!missing()) return;
    const { texts } = await build.part(later[part]);
    if (!missing()) return; // another language was chosen meanwhile
    this.catalogue = { ...this.catalogue, ...texts };
    this.loaded.add(part);
  }

  /** Locale for dates and times: 24 hours and day before month, also in English. */
  get dates(): string {
    return this.locale === "en" ? "en-GB" : this.locale;
  }

  /** As the language writes it, with a true minus sign: "12.5", "12,5". */
  number(
    value: number,
    digits: Intl.NumberFormatOptions = { maximumSignificantDigits: 6 },
  ): string {
    const key = `${this.locale} ${JSON.stringify(digits)}`;
    let form = this.numbers.get(key);
    if (!form) {
      form = new Intl.NumberFormat(this.locale, { useGrouping: "min2", ...digits });
      this.numbers.set(key, form);
    }
    return form
      .format(value)
      .replace(/^-(?=[0.,]+$)/, "") // "-0.0" of a number that is rounded to nothing
      .replace("-", "−");
  }

  has(key: string): boolean {
    return key in this.catalogue;
  }

  /** @param count  chooses the plural form of a text that has several */
  text(key: Key, count?: number): string {
    return formOf(this.catalogue[key] ?? "", count, this.plurals);
  }
}

/** The form of `text` for `count` things. */
export function formOf(text: Text, count: number | undefined, plurals: Intl.PluralRules): string {
  if (typeof text === "string") return text;
  return text[plurals.select(count ?? Number.NaN)] ?? text.other ?? "";
}

export const i18n = new I18n();

/** Loads a part of the page together with the texts that it needs. */
export async function late<T>(load: () => Promise<T>, texts?: Later): Promise<T> {
  const [part] = await busyDuring(Promise.all([build.part(load), i18n.loadAll(texts)]));
  return part;
}

/**
 * The text of `key` in the current language, with {name} replaced. A number is written as the
 * language writes it; the number `count`, or else `most`, chooses the plural form.
 */
export function t(key: Key, values: Record<string, string | number> = {}): string {
  const count = values.count ?? values.most;
  const said = Object.entries(values).map(([name, value]) => [
    name,
    typeof value === "number" ? i18n.number(value) : value,
  ]);
  return fill(i18n.text(key, Number(count)), Object.fromEntries(said));
}

export function fill(text: string, values: Record<string, string | number>): string {
  return text.replace(/\{(\w+)\}/g, (whole, name: string) => String(values[name] ?? whole));
}
