import type { en } from "./en";
import type { enMore } from "./en_more";

export type Key = keyof typeof en | keyof typeof enMore;
/** All texts of the page in one language. */
export type Catalogue = Record<Key, string>;
