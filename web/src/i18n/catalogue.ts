import type { texts } from "./languages/en";

export type Key = keyof typeof texts;
/** A sentence, or one for each plural category of the language that {count} can have. */
export type Text = string | Partial<Record<Intl.LDMLPluralRule, string>>;
/** All texts of the page in one language. */
export type Catalogue = Record<Key, Text>;
