// Tests start with all texts loaded, as the page has them after its first moment.
import { i18n } from "../../src/i18n/i18n.svelte";

await i18n.loadAll();
