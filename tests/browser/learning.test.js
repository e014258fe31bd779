// The first seconds of a run: the server calibrates the healthy rig, and changes wait for the end
// of this.
import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import { makeWorld, pageOf } from "./lab_world.js";
import { launchBrowser, openPage, SUITE_MS, startServer, story, waitForReview } from "./support.js";

/** Starts a run without a planned fault and waits for its sliders; returns the run's id. */
async function startHealthyRun(page, seconds, anew = true) {
  await page.getByLabel("Duration, s").fill(String(seconds));
  await page.getByLabel("learn the healthy rig again").setChecked(anew);
  await page.locator("#set-R1").focus();
  await page.keyboard.press("1");
  await page.getByRole("button", { name: "Run this experiment" }).click();
  await page.waitForURL(/\/lab\/.+/);
  await page.locator("#set-R1:not([disabled])").waitFor();
  return decodeURIComponent(new URL(page.url()).pathname.split("/")[2]);
}

async function eventsOf(page, url, id) {
  const answer = await page.request.get(`${url}/api/v1/runs/${id}/events`);
  return (await answer.json()).items;
}

describe("while the healthy rig is learnt", { timeout: SUITE_MS }, () => {
  let server;
  let browser;

  before(async () => {
    server = await startServer({ speed: 0.5 }); // ten seconds for the clicks, enough on any machine
    browser = await launchBrowser();
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  story("a slider touched in the first seconds waits, counts down, and is named", async () => {
    const { page, context, close } = await openPage(browser, server.url);
    const id = await startHealthyRun(page, 9);
    await page.locator(".verdict", { hasText: /\d\.\d s of 4\.5 s learnt/ }).waitFor();
    await page.getByText(/Learning the healthy rig: [1-5]\.\d s left/).waitFor();
    await page.locator("#set-R1").focus();
    await page.keyboard.press("4");
    await page.locator(".slider.waiting #set-R1").waitFor();
    const armed = page.locator(".armed", { hasText: /R1 → 100 Ω in [0-5]\.\d s/ });
    await armed.waitFor();

    const second = await context.newPage(); // another user's tab, opened later
    await second.goto(page.url());
    await second.locator(".slider.waiting #set-R1").waitFor();
    await second.close();

    await page.locator(".slider.confirmed #set-R1").waitFor();
    await armed.waitFor({ state: "detached" });
    await waitForReview(page);
    assert.match(await page.locator(".verdict .heading").innerText(), /Fault: R1 ↑/);
    const sized = await page.locator(".verdict .value b").first().innerText();
    assert.ok(Math.abs(Number.parseFloat(sized) - 100) < 3, sized);
    const events = await eventsOf(page, server.url, id);
    const of = (kind) => events.find((event) => event.kind === kind);
    assert.ok(of("change_waits").index < 500);
    assert.ok(of("relay_confirmed").index > 500, "not before the healthy rig is learnt");
    assert.ok(of("relay_confirmed").index < 600);
    await close();
  });

  story("a change that waits can be replaced and cancelled", async () => {
    const { page, close } = await openPage(browser, server.url);
    const id = await startHealthyRun(page, 7);
    await page.locator("#set-R12").focus();
    await page.keyboard.press("2");
    await page.locator(".armed", { hasText: "R12 → 5.6 kΩ" }).waitFor();
    await page.keyboard.press("4");
    await page.locator(".armed", { hasText: "R12 → 2 kΩ" }).waitFor();
    await page.locator(".armed").getByRole("button", { name: "Cancel" }).click();
    await page.locator(".slider.nominal #set-R12").waitFor();
    await waitForReview(page);
    assert.match(await page.locator(".verdict .heading").innerText(), /No fault/);
    const kinds = (await eventsOf(page, server.url, id)).map((event) => event.kind);
    assert.ok(kinds.includes("change_dropped"), kinds.join());
    assert.ok(!kinds.includes("fault_commanded"), kinds.join());
    await close();
  });

  story("the next run of the hour starts at once, and says what it starts with", async () => {
    const quick = await startServer({ speed: 4 });
    const world = await makeWorld(quick);
    const mika = await world.user("mika", "Mika", "student");
    await world.run(mika, { duration_s: 8 });
    const { page, close } = await pageOf(browser, quick, mika, "/");
    const id = await startHealthyRun(page, 20, false);
    await page
      .locator(".verdict", { hasText: /The healthy rig was learnt in an earlier run, on/ })
      .waitFor();
    assert.match(await page.locator(".verdict .heading").innerText(), /No fault/);
    await waitForReview(page);
    const run = await (await page.request.get(`${quick.url}/api/v1/runs/${id}`)).json();
    assert.ok(run.plan.calibration.run.startsWith("run-"));
    await close();
    await quick.stop();
  });

  story("a spoilt beginning is said, and the rig is learnt again within the run", async () => {
    const spoilt = {
      bench: "paper",
      duration_s: 40,
      faults: [
        { component: "R1", value: 100, at_s: 1 },
        { component: "R1", value: 1, at_s: 5.5 },
      ],
    };
    const quick = await startServer({ speed: 2 });
    const { page, close } = await openPage(browser, quick.url);
    const answer = await page.request.post(`${quick.url}/api/v1/runs`, { data: spoilt });
    const { id } = await answer.json();
    await page.goto(`${quick.url}/lab/${id}`);
    const again = page.getByRole("button", { name: "Learn the healthy rig again" });
    await page.locator(".verdict .primary", { hasText: "Learn the healthy rig again" }).waitFor();
    await page.locator(".slider.nominal #set-R1:not([disabled])").waitFor();
    await again.click();
    await page.locator(".verdict.nominal").waitFor();
    await page.locator("#set-R1").focus();
    await page.keyboard.press("4");
    await page.locator(".verdict .heading", { hasText: "Fault: R1 ↑" }).waitFor();
    const kinds = (await eventsOf(page, quick.url, id)).map((event) => event.kind);
    assert.ok(kinds.indexOf("not_learnt") < kinds.indexOf("learning"), kinds.join());
    assert.ok(kinds.indexOf("learning") < kinds.indexOf("learnt"), kinds.join());
    await close();
    await quick.stop();
  });

  story("a plan with a fault in these seconds is warned of", async () => {
    const { page, close } = await openPage(browser, server.url);
    const warning = page.getByText("a fault in that time leaves such a run without a diagnosis");
    await page.getByLabel("Fault at, s").fill("6");
    assert.equal(await warning.count(), 0);
    await page.getByLabel("Fault at, s").fill("2");
    await warning.waitFor();
    await close();
  });
});
