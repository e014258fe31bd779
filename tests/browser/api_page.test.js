// The API page: requests are sent from it, and the programs that it gives run as they are.
import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { after, before, describe } from "node:test";
import { promisify } from "node:util";
import { makeWorld, pageOf } from "./lab_world.js";
import { axe, launchBrowser, openPage, SUITE_MS, startServer, story } from "./support.js";

const run = promisify(execFile);

describe("API page", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let world;
  let key;

  before(async () => {
    server = await startServer({ speed: 10 });
    browser = await launchBrowser();
    world = await makeWorld(server);
    const { json } = await world.call(world.admin, "POST", "/api-keys", {
      name: "copied",
      scopes: ["runs:read", "runs:write", "jobs", "lab"],
      expires_at: new Date(Date.now() + 3_600_000).toISOString(),
    });
    key = json.key;
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  /** Opens a route and returns its card. */
  async function open(page, path, method = "GET") {
    const card = page
      .locator("details")
      .filter({ has: page.locator("code").getByText(path, { exact: true }) })
      .filter({ has: page.locator("b.method").getByText(method, { exact: true }) });
    await card.locator("summary").click();
    await card.getByRole("button", { name: "Send" }).waitFor();
    return card;
  }
  /** The text of the clipboard after the button was pressed. */
  async function copied(page, card, what) {
    await card.getByRole("button", { name: `Copy ${what}` }).click();
    await card.getByText("Copied.").first().waitFor();
    return page.evaluate(() => navigator.clipboard.readText());
  }
  const env = () => ({ ...process.env, FAULTLAB_KEY: key });
  const shell = async (text) => (await run("sh", ["-c", text], { env: env() })).stdout;
  const python = async (text) => (await run("python3", ["-c", text], { env: env() })).stdout;

  story("a guest reads the rigs, and both copied programs read the same", async () => {
    const { page, context, close } = await openPage(browser, `${server.url}/api`);
    await context.grantPermissions(["clipboard-read", "clipboard-write"], { origin: server.url });
    const card = await open(page, "/api/v1/rigs");
    await card.getByRole("button", { name: "Send" }).click();
    await card.getByText("200 OK").waitFor();
    await card.getByText("application/json").first().waitFor();
    assert.match(await card.getByLabel("Answer").innerText(), /"id": "sim-1"/);
    assert.deepEqual(await axe(page), []);
    const curl = await copied(page, card, "curl");
    assert.doesNotMatch(curl, /FAULTLAB_KEY/);
    assert.match(await shell(curl), /HTTP\/1.1 200[\s\S]*"id":"sim-1"/);
    assert.match(await python(await copied(page, card, "Python")), /^200[\s\S]*"id": "sim-1"/);
    await close();
  });

  story("a change is asked about once, then made; the programs make it with a key", async () => {
    const { page, context, close } = await pageOf(browser, server, world.admin, "/api");
    await context.grantPermissions(["clipboard-read", "clipboard-write"], { origin: server.url });
    const card = await open(page, "/api/v1/jobs", "POST");
    await card.getByLabel(/^Body/).fill('{"name": "it\'s $HOME", "runs": [{"duration_s": 2}]}');
    await card.getByRole("button", { name: "Send", exact: true }).click();
    await card.getByText(/POST changes something/).waitFor();
    const count = async () => (await world.call(world.admin, "GET", "/jobs")).json.items.length;
    assert.equal(await count(), 0, "nothing is sent before the answer");
    await card.getByRole("button", { name: "Cancel" }).click();
    await card.getByRole("button", { name: "Send", exact: true }).click();
    await card.getByRole("button", { name: "Yes, send" }).click();
    await card.getByText("202 Accepted").waitFor();
    assert.equal(await count(), 1);
    assert.match(await shell(await copied(page, card, "curl")), /HTTP\/1.1 202[\s\S]*it's \$HOME/);
    assert.match(await python(await copied(page, card, "Python")), /^202[\s\S]*it's \$HOME/);
    assert.equal(await count(), 3);
    assert.deepEqual(await axe(page), []);
    await close();
  });

  story("parameters stand in path and query; a pasted key is used, not the sign-in", async () => {
    const { json } = await world.call(world.admin, "POST", "/runs", { duration_s: 2 });
    const { page, context, close } = await openPage(browser, `${server.url}/api`, {
      allow: /status of 40\d/,
    });
    await context.grantPermissions(["clipboard-read", "clipboard-write"], { origin: server.url });
    const card = await open(page, "/api/v1/runs/{id}/events");
    await card.getByLabel(/^id/).fill(json.id);
    await card.getByRole("button", { name: "Send" }).click();
    await card.getByText(/^4\d\d [A-Z]/).waitFor(); // it is somebody's
    await page.getByLabel(/^API key/).fill(key);
    await card.getByRole("button", { name: "Send" }).click();
    await card.getByText("200 OK").waitFor();
    const curl = await copied(page, card, "curl");
    assert.ok(!curl.includes(key), "a secret is not written into a program");
    assert.match(await shell(curl), /"kind":"started"/);
    assert.match(await python(await copied(page, card, "Python")), /"kind": "started"/);
    await close();
  });

  story("fits a phone, in both themes", async () => {
    for (const colorScheme of ["light", "dark"]) {
      const { page, close } = await openPage(browser, `${server.url}/api`, {
        viewport: { width: 390, height: 844 },
        colorScheme,
      });
      const card = await open(page, "/api/v1/rigs");
      await card.scrollIntoViewIfNeeded();
      const over = await page.evaluate(
        () => document.documentElement.scrollWidth - document.documentElement.clientWidth,
      );
      assert.equal(over, 0);
      assert.deepEqual(await axe(page), []);
      if (process.env.SHOT_API) {
        await page.screenshot({ path: `${process.env.SHOT_API}-${colorScheme}.png` });
      }
      await close();
    }
  });
});
