// What an operator looks at: checks, alarms, the queue, planned outages, searches.
import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import { makeWorld, pageOf } from "./lab_world.js";
import { axe, confirmIn, launchBrowser, SUITE_MS, startServer, story } from "./support.js";

describe("operate", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let world;
  const people = {};

  before(async () => {
    server = await startServer({ speed: 10, benches: 2 });
    browser = await launchBrowser();
    world = await makeWorld(server);
    for (const [login, name] of [
      ["ana", "Ana Đurić"],
      ["boris", "Boris"],
      ["ceca", "Ceca"],
    ]) {
      people[login] = await world.user(login, name, "student");
    }
    await world.benchesReady(2);
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });
  const region = (page, name) => page.getByRole("region", { name, exact: true });

  story("an alarm says what to do, is acknowledged by name, and goes when it is over", async () => {
    const { page, close } = await pageOf(browser, server, world.admin, "/admin");
    await page.getByText(/^No alarms/).waitFor();
    await page.getByRole("button", { name: "Quarantine bench-1" }).click();
    await page.getByLabel("Reason").fill("smells of smoke");
    await page
      .getByRole("dialog")
      .getByRole("button", { name: /^Quarantine/ })
      .click();
    const alarms = region(page, "Alarms");
    const alarm = alarms.getByRole("listitem");
    await alarm.getByText("bench-1: in quarantine").waitFor();
    await alarm.getByText("smells of smoke").waitFor();
    await alarm.getByText(/^Look at the rig/).waitFor();
    await alarm.getByRole("button", { name: /^Acknowledge bench-1/ }).click();
    await alarm.getByText(/^seen by/).waitFor();
    assert.deepEqual(await axe(page), []);
    if (process.env.SHOT_ALARMS) await page.screenshot({ path: process.env.SHOT_ALARMS });
    await page.getByRole("button", { name: "Release bench-1" }).click();
    await page.getByText(/^No alarms/).waitFor();
    await alarms.getByLabel("show past alarms").check();
    await alarm.getByText("over", { exact: true }).waitFor();
    await close();
    await world.benchesReady(2);
  });

  story("a self-test shows its result step by step, and is kept", async () => {
    const { page, close } = await pageOf(browser, server, world.admin, "/admin");
    const rig = region(page, "Rigs now").getByRole("listitem").filter({ hasText: "bench-2" });
    await page.getByRole("button", { name: "Self-test bench-2" }).click();
    await rig.getByText(/^Checks, use and relays/).click();
    const check = rig.getByText(/^✓ passed.*self-test/);
    await check.waitFor();
    await check.click();
    const table = rig.locator("details[open] details[open]").getByRole("region");
    await table.getByText("Relay read back: R1 = 10 Ω, Do16").waitFor();
    const gain = table.getByRole("row").filter({ hasText: "Gain" });
    assert.match(await gain.innerText(), /1\/V.*….*1\/V.*passed/s);
    await rig.getByText("last 30 days").waitFor();
    await rig.getByText(/has no relays/).waitFor();
    assert.deepEqual(await axe(page), []);
    if (process.env.SHOT_HISTORY) {
      await page.screenshot({ path: process.env.SHOT_HISTORY, fullPage: true });
    }
    await page.reload();
    await rig.getByText(/^Checks, use and relays/).click();
    await check.waitFor();
    await close();
  });

  story("an outage names the bookings in its way before it is planned", async () => {
    const start = new Date(Date.now() + 24 * 3_600_000);
    start.setHours(12, 0, 0, 0); // the week begins at 7:00
    const end = new Date(start.getTime() + 3_600_000);
    const when = { rig_class: "bench", start: start.toISOString(), end: end.toISOString() };
    const { json: first } = await world.call(people.ana, "POST", "/bookings", when);
    const { page, close } = await pageOf(browser, server, world.admin, "/admin");
    await page.getByRole("button", { name: "Plan an outage", exact: true }).click();
    const dialog = page.getByRole("dialog");
    await dialog.getByLabel("Rig").selectOption(first.rig);
    const local = (moment) =>
      new Date(moment.getTime() - moment.getTimezoneOffset() * 60_000).toISOString().slice(0, 16);
    await dialog.getByLabel("To", { exact: true }).fill(local(start));
    await dialog.getByLabel("From", { exact: true }).fill(local(end));
    await dialog.getByText("The end must come after the beginning.").waitFor();
    await dialog.getByLabel("From", { exact: true }).fill(local(start));
    await dialog.getByLabel("To", { exact: true }).fill(local(end));
    await dialog.getByLabel(/^Reason/).fill("new brushes");
    const other = first.rig === "bench-1" ? "bench-2" : "bench-1";
    await dialog.getByText(`moves to ${other}, at the same time`).waitFor();
    await dialog.getByText("Ana Đurić").waitFor();
    await world.call(people.boris, "POST", "/bookings", when);
    await dialog.getByLabel("To", { exact: true }).fill(local(new Date(end.getTime() + 60_000)));
    await dialog.getByText("is cancelled: no equal rig is free then").waitFor();
    assert.deepEqual(await axe(page), []);
    if (process.env.SHOT_OUTAGE) await page.screenshot({ path: process.env.SHOT_OUTAGE });
    assert.equal((await world.call(people.ana, "GET", "/bookings")).json.items.length, 1);
    await dialog.getByRole("button", { name: "Plan an outage" }).click();
    await dialog.waitFor({ state: "detached" });
    assert.equal((await world.call(people.ana, "GET", "/bookings")).json.items.length, 0);
    const { json: kept } = await world.call(people.boris, "GET", "/bookings");
    assert.equal(kept.items[0].rig, other);

    const theirs = await pageOf(browser, server, people.ceca, "/book");
    const slot = theirs.page.getByRole("button", { name: /planned outage of .*new brushes/ });
    await slot.first().waitFor();
    assert.deepEqual(await axe(theirs.page), []);
    await theirs.close();
    await region(page, "Rigs now")
      .getByRole("button", { name: new RegExp(`^Remove .*${first.rig}`) })
      .click();
    await confirmIn(page);
    await region(page, "Rigs now").getByText("new brushes").waitFor({ state: "detached" });
    await close();
  });

  story("the queue names who waits, since when, and when a rig is expected", async () => {
    for (const who of Object.values(people)) {
      await world.call(who, "POST", "/tickets", { rig_class: "bench" });
    }
    const { page, close } = await pageOf(browser, server, world.admin, "/admin");
    const queue = region(page, "Queue");
    await queue
      .getByRole("row")
      .filter({ hasText: "Ceca" })
      .getByText("1", { exact: true })
      .waitFor();
    assert.equal(await queue.getByRole("row").count(), 4);
    await queue.getByText("offered").first().waitFor();
    assert.deepEqual(await axe(page), []);
    await close();
  });

  story("people and the log are searched", async () => {
    const { page, close } = await pageOf(browser, server, world.admin, "/admin");
    const users = page.getByRole("listitem").filter({ has: page.getByLabel(/^Role /) });
    await users.filter({ hasText: "boris" }).waitFor();
    await page.getByLabel("Name, login or mail").fill("đurIĆ");
    await page.getByLabel("Name, login or mail").press("Enter");
    await users.filter({ hasText: "boris" }).waitFor({ state: "detached" });
    assert.equal(await users.count(), 1);
    await page.getByLabel("Name, login or mail").fill("nobody at all");
    await page.getByLabel("Name, login or mail").press("Enter");
    await page.getByText("Nobody matches.").waitFor();
    await page.getByRole("button", { name: "Show all" }).click();
    await users.filter({ hasText: "boris" }).waitFor();

    const log = region(page, "Audit log").getByRole("row");
    await page.getByLabel("Words").fill("quarantined");
    await page.getByLabel("Words").press("Enter");
    await log.filter({ hasText: "made the user" }).first().waitFor({ state: "detached" });
    assert.ok((await log.filter({ hasText: "quarantined bench-1" }).count()) >= 1);
    await page.getByLabel("Words").fill("");
    await page.getByLabel("Who", { exact: true }).fill("nobody");
    await page.getByLabel("Who", { exact: true }).press("Enter");
    await page.getByText("No entry matches.").waitFor();
    await close();
  });

  story("the page fits a phone, in both themes", async () => {
    for (const colorScheme of ["light", "dark"]) {
      const { page, close } = await pageOf(browser, server, world.admin, "/admin", {
        viewport: { width: 390, height: 844 },
        colorScheme,
      });
      await page
        .getByText(/^Checks, use and relays/)
        .first()
        .click();
      await page.getByText("last 30 days").waitFor();
      const over = await page.evaluate(
        () => document.documentElement.scrollWidth - document.documentElement.clientWidth,
      );
      assert.equal(over, 0, "nothing is wider than the screen");
      assert.deepEqual(await axe(page), []);
      if (process.env.SHOT_PHONE) {
        await page.screenshot({
          path: `${process.env.SHOT_PHONE}-${colorScheme}.png`,
          fullPage: true,
        });
      }
      await close();
    }
  });
});
