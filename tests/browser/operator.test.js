import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import { makeWorld, pageOf } from "./lab_world.js";
import {
  axe,
  confirmIn,
  holdRequests,
  launchBrowser,
  openPage,
  SUITE_MS,
  startAgent,
  startServer,
  story,
  until,
} from "./support.js";

/** The row of a rig; alarms name rigs, too. */
const rigOf = (page, id) =>
  page
    .getByRole("region", { name: "Rigs now" })
    .getByRole("listitem")
    .filter({ has: page.getByText(id, { exact: true }) })
    .first();

describe("operator", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let world;

  before(async () => {
    server = await startServer({ speed: 10, benches: 2 });
    browser = await launchBrowser();
    world = await makeWorld(server);
    await world.benchesReady(2);
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  story("no card pushes down what is pressed below it: they come from the top down", async () => {
    const { page, close } = await pageOf(browser, server, world.admin, "/help");
    const health = await holdRequests(page, /\/rigs\/[^/]+\/health/);
    await page.goto(`${server.url}/admin`);
    await page.getByRole("region", { name: "Rigs now" }).waitFor();
    await health.arrived;
    const below = page.getByRole("heading", { name: "Sessions now" });
    assert.equal(await below.isVisible(), false);
    await health.letGo();
    await below.waitFor();
    assert.ok(await rigOf(page, "bench-1").isVisible());
    await close();
  });

  story("a rig goes into quarantine with a reason, and comes back through a check", async () => {
    const { page, close } = await pageOf(browser, server, world.admin, "/admin");
    const rig = rigOf(page, "bench-1");
    await rig.getByText("free").waitFor();
    await page.getByRole("button", { name: "Quarantine bench-1" }).click();
    await page.getByLabel("Reason").fill("smells of smoke");
    await page
      .getByRole("dialog")
      .getByRole("button", { name: /^Quarantine/ })
      .click();
    await rig.getByText("quarantined").waitFor();
    await rig.getByText("smells of smoke").waitFor();
    assert.deepEqual(await axe(page), []);
    await page.getByRole("button", { name: "Release bench-1" }).click();
    await rig.getByText("free").waitFor();
    await close();
  });

  story(
    "an outage takes a rig out and says so to everybody; removed, the rig is checked and free",
    async () => {
      const { page, close } = await pageOf(browser, server, world.admin, "/admin");
      const rig = rigOf(page, "bench-2");
      await page.getByRole("button", { name: "Outage bench-2" }).click();
      const dialog = page.getByRole("dialog");
      assert.equal(await dialog.getByLabel("Rig").inputValue(), "bench-2");
      await dialog.getByLabel("Reason").fill("new brushes");
      await dialog.getByText("No booking and no session is in the way.").waitFor();
      await dialog.getByRole("button", { name: "Plan an outage" }).click();
      await rig.getByText("maintenance").waitFor();
      await rig.getByText(/planned outage: .*new brushes/).waitFor();

      const guest = await openPage(browser, `${server.url}/status`);
      await guest.page
        .getByRole("listitem")
        .filter({ hasText: "bench-2" })
        .getByText("maintenance")
        .waitFor();
      assert.deepEqual(await axe(guest.page), []);
      await guest.close();

      await rig.getByRole("button", { name: /^Remove/ }).click();
      await confirmIn(page);
      await rig.getByText("free").waitFor();
      await page.getByRole("button", { name: "Self-test bench-2" }).click();
      await rig.getByText("free").waitFor();
      await close();
    },
  );

  story("an account is disabled and its open page says that the sign-in has ended", async () => {
    const student = await world.user("pera", "Pera", "student");
    const theirs = await pageOf(browser, server, student, "/jobs", { allow: /status of 401/ });
    await theirs.page.getByRole("heading", { name: "Jobs", exact: true }).waitFor();
    const { page, close } = await pageOf(browser, server, world.admin, "/admin");
    await page.getByRole("button", { name: "Disable pera" }).click();
    await confirmIn(page);
    await page.getByRole("button", { name: "Enable pera" }).waitFor();
    const submit = theirs.page.getByRole("button", { name: /^Submit/ });
    await submit.click({ timeout: 2000 }).catch(() => {}); // the page may know it already
    await theirs.page.getByRole("alert").filter({ hasText: "Your sign-in has ended" }).waitFor();
    await theirs.page.getByRole("heading", { name: "Sign in to see this page" }).waitFor();
    assert.deepEqual(await axe(theirs.page), []);

    await page.getByRole("button", { name: "Enable pera" }).click();
    await page.getByRole("button", { name: "Disable pera" }).waitFor();
    await theirs.page.getByRole("main").getByRole("link", { name: "Sign in" }).click();
    await theirs.page.getByLabel("Login").fill("pera");
    await theirs.page.getByLabel("Password").fill("correct horse battery");
    await theirs.page.getByRole("main").getByRole("button", { name: "Sign in" }).click();
    await theirs.page.getByRole("heading", { name: "Jobs", exact: true }).waitFor(); // the page on which they were
    await theirs.close();

    await page.reload();
    const audit = page.getByRole("region", { name: "Audit log" });
    await audit
      .getByText(/changed the user pera/)
      .first()
      .waitFor();
    await audit.getByText(/quarantined bench-1/).waitFor();
    await close();
  });

  story("a rig is commissioned with a reason, and what a run has learnt is shown", async () => {
    const { json } = await world.call(world.admin, "POST", "/tickets", { rig_class: "bench" });
    const accept = `/tickets/${json.ticket.id}/accept`;
    const { json: session } = await world.call(world.admin, "POST", accept, {});
    await world.call(world.admin, "POST", "/runs", { rig: session.rig, duration_s: 8 });
    const { page, close } = await pageOf(browser, server, world.admin, "/admin");
    const newest = async () =>
      (await world.call(world.admin, "GET", `/rigs/${session.rig}/calibrations?limit=1`)).json;
    await until(newest, ({ items }) => items.length > 0);
    await world.call(world.admin, "POST", `/sessions/${session.id}/end`, {});
    await page.reload();
    const rig = rigOf(page, session.rig);
    await rig.getByText(/^Calibrated/).click();
    await rig.getByRole("cell", { name: "R1", exact: true }).waitFor();
    await rig.getByText("free").waitFor();
    await page.getByRole("button", { name: `Commission ${session.rig}` }).click();
    await page.getByLabel("Reason").fill("new motor");
    await page
      .getByRole("dialog")
      .getByRole("button", { name: /^Commission/ })
      .click();
    const audit = async () => (await world.call(world.admin, "GET", "/audit?limit=1")).json;
    await until(audit, ({ items }) => items[0].verb === "commission");
    await rig.getByText("free").waitFor();
    assert.deepEqual(await axe(page), []);
    if (process.env.SHOT_ADMIN)
      await page.screenshot({ path: process.env.SHOT_ADMIN, fullPage: true });
    await close();
  });

  story("a far rig that has seen a higher epoch is adopted, and then free", async (context) => {
    const agent = await startAgent({ id: "far-1", epoch: 500 });
    if (!agent) return context.skip("no multicast on this machine");
    context.after(() => agent.stop());
    const lab = await startServer({ bus: agent.bus });
    context.after(() => lab.stop());
    const { admin } = await makeWorld(lab);
    const { page, close } = await pageOf(browser, lab, admin, "/admin");
    const rig = rigOf(page, "far-1");
    await rig.getByText(/has seen epoch 500, but the laboratory is only at 1/).waitFor();
    await rig.getByText("quarantined").waitFor();
    assert.equal(await page.getByRole("button", { name: /^Adopt/ }).count(), 1, "no other rig");
    await page.getByRole("button", { name: "Adopt far-1" }).click();
    const dialog = page.getByRole("dialog");
    await dialog.getByText(/goes on from epoch 500, ends a session/).waitFor();
    assert.deepEqual(await axe(page), []);
    if (process.env.SHOT_ADOPT) await page.screenshot({ path: process.env.SHOT_ADOPT });
    await dialog.getByRole("button", { name: "Cancel" }).click();
    await rig.getByText("quarantined").waitFor();
    await page.getByRole("button", { name: "Adopt far-1" }).click();
    await dialog.getByRole("button", { name: /^Adopt/ }).click();
    await rig.getByText("free").waitFor();
    await rig.getByText(/has seen epoch/).waitFor({ state: "detached" });
    await page.reload();
    await page.getByText(/adopted the epoch of far-1.*500/).waitFor();
    await close();
  });

  story("a calendar address is shown once, works without signing in, and ends", async () => {
    const { page, close } = await pageOf(browser, server, world.admin, "/account");
    await page.getByRole("button", { name: "Make an address" }).click();
    const address = await page.getByText(/calendar\/flc_/).textContent();
    const bookings = await fetch(address);
    assert.equal(bookings.status, 200);
    assert.match(await bookings.text(), /^BEGIN:VCALENDAR/);
    assert.deepEqual(await axe(page), []);
    await page.getByRole("button", { name: "End the address" }).click();
    await confirmIn(page);
    await page.getByRole("button", { name: "Make an address" }).waitFor();
    assert.equal((await fetch(address)).status, 404);
    await close();
  });

  story("what a role may not open says so", async () => {
    const student = await world.user("laza", "Laza", "student");
    const { page, close } = await pageOf(browser, server, student, "/admin");
    await page.getByRole("heading", { name: "Your role does not open this page" }).waitFor();
    assert.deepEqual(await axe(page), []);
    await close();
  });
});
