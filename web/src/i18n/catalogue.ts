import type { en } from "./en";
import type { enMore } from "./en_more";

export type Key = keyof typeof en | keyof typeof enMore;
/** Every text of the page in one language. */
export type Catalogue = Record<Key, string>;
