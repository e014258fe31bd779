import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import { startCamera } from "./camera_site.js";
import {
  axe,
  launchBrowser,
  openPage,
  SUITE_MS,
  startServer,
  story,
  waitForDrawings,
  waitForReview,
  waitForRunTime,
} from "./support.js";

const PLAN = {
  duration_s: 300,
  faults: [{ component: "R1", value: 100, at_s: 8 }],
};
const CANVAS = '[aria-label="Camera picture of sim-1"] canvas';

describe("camera of a bench", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let camera;

  before(async () => {
    browser = await launchBrowser();
    camera = await startCamera(browser);
    server = await startServer({
      settings: `[[camera]]\nrig = "sim-1"\nsnapshot = "${camera.url}"\ntimeout_s = 10\n`,
    });
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
    camera?.close();
  });

  async function startRun(plan) {
    const answer = await fetch(`${server.url}/api/v1/runs`, {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(plan),
    });
    const run = await answer.json();
    assert.equal(answer.status, 201, JSON.stringify(run));
    return run;
  }
  async function stop(run) {
    const answer = await fetch(`${server.url}/api/v1/runs/${run.id}/stop`, { method: "POST" });
    assert.equal(answer.status, 202, await answer.text());
  }
  const benchCard = (page) =>
    page.locator(".card", { has: page.getByRole("heading", { name: "Bench", exact: true }) });

  story(
    "the picture changes twice a second, says its age, and is stored with the run",
    async () => {
      const run = await startRun({ ...PLAN, rig: "sim-1" });
      assert.equal(run.camera, true);
      const { page, close } = await openPage(browser, `${server.url}/lab/${run.id}`, {
        allow: /camera|404/, // the last picture was asked for when the run had ended
      });
      const card = benchCard(page);
      await card.getByText(/^\d\.\d s old$/).waitFor();
      const before = camera.asked;
      const since = Date.now();
      await waitForDrawings(page, CANVAS, 5);
      const rate = (camera.asked - before) / ((Date.now() - since) / 1000);
      assert.ok(rate < 3.5, `the camera is asked ${rate.toFixed(1)} times a second`);
      assert.deepEqual(await axe(page), []);
      if (process.env.PICTURES) {
        await page.screenshot({ path: `${process.env.PICTURES}/camera-live.png`, fullPage: true });
      }
      await waitForRunTime(page, 10);
      await stop(run);
      await waitForReview(page);

      const stored = card.getByRole("img");
      await card.getByRole("img", { name: /s: end of the run$/ }).waitFor();
      const names = await stored.evaluateAll((all) => all.map((each) => each.alt));
      assert.equal(names[0], "8.00 s: fault switched");
      assert.match(names.at(1), /^8\.\d\d s: fault detected$/);
      await page.waitForFunction(() =>
        [...document.querySelectorAll("li img")].every((each) => each.naturalWidth === 320),
      );
      assert.deepEqual(await axe(page), []);
      if (process.env.PICTURES) {
        await page.screenshot({
          path: `${process.env.PICTURES}/camera-review.png`,
          fullPage: true,
        });
      }
      await close();
    },
  );

  story("a camera that fails is said, with the age of the last picture", async () => {
    const run = await startRun({ duration_s: 120, rig: "sim-1" });
    const { page, close } = await openPage(browser, `${server.url}/lab/${run.id}`, {
      allow: /503|404/,
    });
    const card = benchCard(page);
    await card.getByText(/s old$/).waitFor();
    camera.works = false;
    await card.getByText(/^The camera gives no picture\. This one is \d+\.\d s old\.$/).waitFor();
    camera.works = true;
    await card.getByText(/^\d\.\d s old$/).waitFor();
    await stop(run);
    await waitForReview(page);
    await close();
  });

  story("a bench without a camera is a drawn motor that turns with n", async () => {
    const run = await startRun({ duration_s: 120, rig: "sim-2" });
    assert.equal(run.camera, false);
    const { page, close } = await openPage(browser, `${server.url}/lab/${run.id}`, {
      reducedMotion: "no-preference",
    });
    const card = benchCard(page);
    await card.getByText(/Animation from the measured n, 20 times slower/).waitFor();
    await card.getByText(/^n = \d+ rpm\.$/).waitFor();
    const angle = () => card.locator(".rotor").getAttribute("transform");
    await page.waitForFunction(() => document.querySelector(".rotor")?.getAttribute("transform"));
    const first = await angle();
    await page.waitForFunction(
      (before) => document.querySelector(".rotor").getAttribute("transform") !== before,
      first,
    );
    if (process.env.PICTURES) {
      await page.screenshot({ path: `${process.env.PICTURES}/motor.png`, fullPage: true });
    }

    const still = await openPage(browser, `${server.url}/lab/${run.id}`); // asks for less motion
    await benchCard(still.page)
      .getByText(/Drawing without motion/)
      .waitFor();
    assert.equal(await benchCard(still.page).locator(".rotor").getAttribute("transform"), null);
    assert.deepEqual(await axe(still.page), []);
    await stop(run);
    await waitForReview(page);
    assert.equal(await card.count(), 0, "no picture was taken");
    await still.close();
    await close();
  });
});
