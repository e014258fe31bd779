import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import { makeWorld, pageOf } from "./lab_world.js";
import { axe, launchBrowser, openPage, SUITE_MS, startServer, story } from "./support.js";

describe("policy", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let world;

  before(async () => {
    server = await startServer({ speed: 10, benches: 1 });
    browser = await launchBrowser();
    world = await makeWorld(server);
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  story("an admin changes it, and whoever looks sees and feels it", async () => {
    const { page, close } = await pageOf(browser, server, world.admin, "/admin");
    const card = page.getByRole("region", { name: "Policy of the lab" });
    const longest = card.getByLabel("Longest booking, min");
    await longest.waitFor();
    assert.equal(await longest.inputValue(), "240");
    await longest.fill("45");
    await card.getByRole("button", { name: "Save the policy" }).click();
    await card.getByText("The policy is saved.").waitFor();
    assert.deepEqual(await axe(page), []);

    const { json } = await world.call(world.admin, "GET", "/policy");
    assert.equal(json.booking_max_s, 45 * 60);
    assert.equal(json.version, 1);
    await close();

    const student = await world.user("ann", "Ann", "student");
    const book = await pageOf(browser, server, student, "/book");
    const minutes = book.page.getByLabel("Minutes");
    await minutes.locator("option", { hasText: "45" }).waitFor({ state: "attached" });
    assert.deepEqual(await minutes.locator("option").allTextContents(), ["15", "30", "45"]);
    await book.close();

    const help = await openPage(browser, `${server.url}/help`);
    const shown = help.page.getByRole("region", { name: "Policy of the lab" });
    await shown.getByText("Longest booking, min").waitFor();
    await shown.getByText("45", { exact: true }).first().waitFor();
    assert.equal(await shown.getByRole("textbox").count(), 0);
    await help.close();

    const log = await world.call(world.admin, "GET", "/audit?verbs=change_policy");
    assert.deepEqual(
      log.json.items.map((each) => each.detail),
      ["booking_max_s 14400 -> 2700"],
    );
  });
});
