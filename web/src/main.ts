import { mount } from "svelte";
import "./theme/app.css";
import App from "./App.svelte";
import { i18n } from "./i18n/i18n.svelte";
import { build } from "./loading/build.svelte";
import { account } from "./shell/account.svelte";
import { router } from "./shell/router.svelte";
import { theme } from "./theme/theme.svelte";

theme.start();
addEventListener("submit", (event) => event.preventDefault()); // no form leads to another page
router.start();
void account.load();
await i18n.start();
mount(App, { target: document.getElementById("app") as HTMLElement });
const { keepFocus } = await build.part(() => import("./shell/focus_keeper"));
keepFocus();
