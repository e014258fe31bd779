// Languages: a further one is a single file and leaves no English on the pages, and Serbian writes and
// reads numbers as Serbian does.
import assert from "node:assert/strict";
import { cpSync, mkdirSync, symlinkSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { after, before, describe } from "node:test";
import { makeWorld, pageOf } from "./lab_world.js";
import {
  freePort,
  launchBrowser,
  openPage,
  PATIENCE_MS,
  SUITE_MS,
  settled,
  startServer,
  story,
  temporaryDirectory,
} from "./support.js";

const WEB = new URL("../../web", import.meta.url).pathname;
const require = createRequire(join(WEB, "package.json"));

/** The whole further language: each text between brackets. en-XA is the tag of such a language. */
const PSEUDO = `
import { texts as en } from "./en";

const said = (text) =>
  typeof text === "string"
    ? "[!! " + text + " !!]"
    : Object.fromEntries(Object.entries(text).map(([form, one]) => [form, said(one)]));
export const texts = Object.fromEntries(Object.entries(en).map(([key, text]) => [key, said(text)]));
`;

/** The page, built with one file more, in front of the server. */
async function pageWith(file, text, server) {
  const { build, preview } = await import(
    require.resolve("vite").replace(/index\.cjs$/, "dist/node/index.js")
  );
  const own = temporaryDirectory();
  const root = join(own.path, "web");
  mkdirSync(root);
  for (const part of ["src", "scripts", "public", "index.html", "package.json", "tsconfig.json"]) {
    cpSync(join(WEB, part), join(root, part), { recursive: true });
  }
  for (const part of ["vite.config.ts", "svelte.config.js"])
    cpSync(join(WEB, part), join(root, part));
  symlinkSync(join(WEB, "node_modules"), join(root, "node_modules"));
  // The build takes the licences and the refusals from beside it.
  for (const file of ["deploy/THIRD_PARTY.md", "core/types/refusals.json"])
    cpSync(join(WEB, "..", file), join(own.path, file));
  writeFileSync(join(root, "src/i18n/languages", file), text);
  process.env.FAULTLAB_URL = server.url;
  await build({ root, logLevel: "error" });
  const port = await freePort();
  const shown = await preview({ root, logLevel: "error", preview: { port, host: "127.0.0.1" } });
  return {
    ...server,
    url: `http://127.0.0.1:${port}`,
    async close() {
      await shown.close();
      own.remove();
    },
  };
}

/** Every text that a person sees or hears: of text nodes, labels and hints. */
function textsOfPage() {
  const texts = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const parent = node.parentElement;
    if (
      parent.closest(
        "script, style, noscript, header select, code, kbd, pre, svg, math, [lang]:not(html)",
      )
    )
      continue;
    texts.push(node.data);
  }
  for (const element of document.querySelectorAll("[aria-label], [title], [placeholder], [alt]")) {
    for (const name of ["aria-label", "title", "placeholder", "alt"]) {
      const text = element.getAttribute(name);
      if (text) texts.push(text);
    }
  }
  return texts.map((text) => text.trim()).filter(Boolean);
}

/** Every text in what the server knows of its benches: their files are in one language. */
function contentsOf(value) {
  if (typeof value === "string") return [value];
  return value && typeof value === "object" ? Object.values(value).flatMap(contentsOf) : [];
}

/** What of a text stands outside of the brackets. */
function outside(text) {
  let depth = 0;
  let left = "";
  for (const part of text.split(/(\[!!|!!\])/)) {
    if (part === "[!!") depth++;
    else if (part === "!!]") depth--;
    else if (depth === 0) left += part;
  }
  return left;
}

describe("languages", { timeout: SUITE_MS }, () => {
  let browser;
  let server;
  let world;
  let people;
  let run;
  let other;
  before(async () => {
    browser = await launchBrowser();
    server = await startServer({ speed: 20, benches: 1 });
    world = await makeWorld(server);
    const mila = await world.user("mila", "Mila", "instructor");
    const mika = await world.user("mika", "Mika", "student");
    const course = await world.course(mila, "Machines", [mika]);
    await world.join(mika, course);
    await world.benchesReady(1);
    people = { mila, mika, admin: world.admin };
    const runOf = (value) =>
      world.run(mika, { faults: [{ component: "R1", value, at_s: 10 }], duration_s: 20 });
    run = await runOf(100);
    other = await runOf(56);
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  const speaking = (locale) => ({ stored: { "faultlab.locale": locale } });
  story("a further language is one file, and no page keeps a word of English", async () => {
    const front = await pageWith("en-XA.ts", PSEUDO, server);
    const { json: benches } = await world.call(people.mika, "GET", "/benches");
    // names and contents, which are nobody's language
    const data = [
      ...contentsOf(benches.items),
      run,
      "faultlab",
      "Administrator",
      "Mila",
      "Mika",
      "mila",
      "mika",
      "admin",
      "Machines",
      "bench",
      "sim-",
      "PRBS",
    ]
      .filter((text) => text.length > 3)
      .sort((a, b) => b.length - a.length);
    const english = (texts) =>
      texts
        .map((text) =>
          data.reduce(
            (left, known) => left.replaceAll(known, ""),
            outside(text).replace(/run-\w+|https?:\S+|\bRFC|JSON/g, ""),
          ),
        )
        .filter((left) => /\p{L}{4,}/u.test(left));
    const found = {};
    const look = async (page, name) => {
      await settled(page);
      const left = english(await page.evaluate(textsOfPage));
      if (left.length > 0) found[name] = [...new Set(left)];
    };
    const visit = async (who, paths) => {
      for (const path of paths) {
        const opened = await pageOf(browser, front, who, path, {
          locale: "en",
          allow: /40\d|429/,
          ...speaking("en-XA"),
        });
        await look(opened.page, path);
        await opened.close();
      }
    };
    await visit(people.mika, [
      "/",
      "/help",
      "/book",
      "/runs",
      "/my",
      "/jobs",
      "/tasks",
      "/account",
      "/status",
      "/learn",
      `/runs/${run}`,
      `/compare?runs=${run},${other}`,
    ]);
    await visit(people.mila, ["/teach"]);
    await visit(people.admin, ["/admin"]);

    const live = await pageOf(browser, front, people.mika, "/", speaking("en-XA"));
    await live.page.getByRole("button", { name: "Run the paper's experiment" }).click();
    await live.page.waitForURL(/\/lab\/.+/);
    await look(live.page, "live");
    await live.close();

    const guest = await openPage(browser, `${front.url}/signin`, {
      allow: /401/,
      ...speaking("en-XA"),
    });
    await guest.page.getByLabel("Login").fill("mika");
    await guest.page.getByLabel("Password").fill("wrong wrong wrong");
    await guest.page.locator("main button.primary").click();
    await guest.page.getByText("[!! The login or the password is wrong. !!]").waitFor();
    await look(guest.page, "a refused sign-in");
    await guest.close();
    await front.close();
    assert.equal(JSON.stringify(found, null, 1), "{}");
  });

  story("Serbian has decimal commas everywhere and understands them", async () => {
    const opened = await pageOf(browser, server, people.mika, `/runs/${run}`, speaking("sr-Latn"));
    const { page } = opened;
    const pointed = async () =>
      (await page.evaluate(textsOfPage)).filter((text) =>
        /\d\.\d/.test(
          text.replace(
            /\S*(?:https?|doi):\S+|RFC \d+|OpenAPI [\d.]+|\d+\.\d+\.\d{4}\.?|\d+\.\s?\d+\.|\d+\.\d+\.\d+\S*/g,
            "",
          ),
        ),
      );
    await page.getByText("PREGLED", { exact: true }).waitFor();
    await page.getByText(/Kvar/).first().waitFor();
    await settled(page);
    assert.match(await page.innerText("main"), /\d,\d/);
    assert.deepEqual(await pointed(), [], "the page of a run");
    for (const path of ["/", "/runs", "/help", `/compare?runs=${run},${other}`]) {
      await page.goto(server.url + path);
      await settled(page);
      assert.deepEqual(await pointed(), [], path);
    }
    await page.goto(server.url);
    const low = page.getByLabel("Donja, V");
    await low.fill("2,25");
    await low.press("ArrowUp");
    assert.equal(await low.inputValue(), "2,35");
    const sent = page.waitForRequest(
      (request) => request.url().endsWith("/runs") && request.method() === "POST",
    );
    await page.getByRole("button", { name: "Pokreni ovaj ogled" }).click();
    assert.equal((await sent).postDataJSON().excitation.low_v, 2.35);
    await page.waitForURL(/\/lab\/.+/, { timeout: PATIENCE_MS });
    await opened.close();
  });
});
