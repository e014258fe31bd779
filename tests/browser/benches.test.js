// Benches that are not the first one's kind: the page shows what their descriptions say.
import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import {
  axe,
  becomes,
  launchBrowser,
  openPage,
  readDownload,
  SUITE_MS,
  settled,
  startServer,
  story,
  waitForReview,
} from "./support.js";

const descriptions = new URL("../../benches/", import.meta.url).pathname;
const BENCHES = [
  {
    file: "servo-motor.toml",
    title: "Motor with a disc on a servo amplifier, 500 Hz",
    sliders: ["Ra", "Ke", "J", "B", "k"],
    window: "(100,20) 240 ms",
    speed: "n, rpm",
    clock: "10.000 s",
    live: { component: "k", key: "2", value: "2 V/V", means: 2 },
  },
  {
    file: "gear-motor.toml",
    title: "Hobby gear motor on an H-bridge",
    sliders: ["Ra", "Ke", "J", "B", "k"],
    window: "(100,20) 1.2 s",
    speed: "n, rpm, behind the gear",
    clock: "10.00 s",
    live: { component: "k", key: "2", value: "1.2 V/V", means: 1.2 },
  },
];
const texts = async (page, selector) =>
  (await page.locator(selector).allInnerTexts()).map((text) => text.replace(/\s+/g, " "));
const bare = (all) => all.map((text) => text.replace(/\s*SIM$/, "").trim());

for (const bench of BENCHES) {
  describe(`a server of ${bench.file}`, { timeout: SUITE_MS }, () => {
    let server;
    let browser;

    before(async () => {
      server = await startServer({ speed: 1, bench: [descriptions + bench.file] });
      browser = await launchBrowser();
    });
    after(async () => {
      await browser?.close();
      await server?.stop();
    });

    story("a run from its plan to its verdict, with a slider moved in between", async () => {
      const { page, context, close } = await openPage(browser, server.url);
      await page.getByRole("button", { name: "Run a first experiment" }).waitFor();
      await becomes(async () => bare(await texts(page, ".slider label")), bench.sliders);
      assert.deepEqual(await axe(page), []);
      await page.getByLabel("Duration, s").fill("14");
      await page.locator(`#set-${bench.sliders[0]}`).focus();
      await page.keyboard.press("1"); // nominal: the fault comes by hand
      await page.getByText("No fault: a healthy run.").waitFor();
      await page.getByRole("button", { name: "Run this experiment" }).click();
      await page.waitForURL(/\/lab\/.+/);

      const { component, key, value, means } = bench.live;
      await page.locator(`#set-${component}:not([disabled])`).focus();
      await page.keyboard.press(key);
      const slider = page.locator(".slider", { has: page.locator(`#set-${component}`) });
      await slider.locator("output", { hasText: value }).waitFor();
      await page.locator(`.slider.confirmed #set-${component}`).waitFor();
      await page
        .locator(`.drawing .faulty[data-part="${component}"]`, { hasText: value })
        .waitFor();
      await becomes(
        () => texts(page, ".signals .title"),
        ["Lens: Uc, V", "Uc, V", "Ia, A", bench.speed],
      );
      await page.getByText(bench.window).waitFor();
      await page.getByRole("button", { name: "SIA of Ia: b0, b1, a1" }).waitFor();
      await waitForReview(page);

      assert.match(
        await page.locator(".verdict .heading").innerText(),
        new RegExp(`: ${component} ↓`),
      );
      const sized = Number.parseFloat(await page.locator(".verdict .value b").first().innerText());
      assert.ok(Math.abs(sized / means - 1) < 0.05, String(sized));
      assert.equal(await page.getByText("Decision path").count(), 0); // nothing is published of it
      assert.equal(await page.getByRole("columnheader", { name: "published" }).count(), 0);
      assert.deepEqual(await axe(page), []);
      await page.keyboard.press("t");
      await page.getByRole("columnheader", { name: "ia, A" }).waitFor();
      assert.equal(await page.getByRole("columnheader", { name: "um, V" }).count(), 0);

      const phone = await context.newPage();
      await phone.setViewportSize({ width: 390, height: 800 });
      await phone.goto(page.url());
      await waitForReview(phone);
      await phone.getByRole("button", { name: "Next run" }).click(); // the sheet has the circuit
      const drawing = phone.getByRole("img", { name: new RegExp(`${component} = ${value}`) });
      await drawing.waitFor();
      const { x, width } = await drawing.boundingBox();
      assert.ok(x >= 0 && x + width <= 390, `${x} ${width}`);
      await close();
    });

    story("the planned fault acts when the plan says, and is found", async () => {
      const quick = await startServer({ speed: 8, bench: [descriptions + bench.file] });
      const { page, close } = await openPage(browser, quick.url);
      await page.getByRole("button", { name: "Run a first experiment" }).click();
      await page.waitForURL(/\/lab\/.+/);
      await waitForReview(page);
      const first = bench.sliders[0];
      assert.match(await page.locator(".verdict .heading").innerText(), new RegExp(`: ${first} ↑`));
      await page.locator(".list li", { hasText: "confirmed" }).getByText(bench.clock).waitFor();
      await close();
      await quick.stop();
    });

    story("help describes it and gives its description", async () => {
      const { page, close } = await openPage(browser, `${server.url}/help`);
      await settled(page);
      await page.getByRole("heading", { name: bench.title }).waitFor();
      const rows = page.getByRole("region", { name: /^Components/ }).locator("tbody th");
      await becomes(() => rows.allInnerTexts(), bench.sliders);
      assert.deepEqual(await axe(page), []);
      const waiting = page.waitForEvent("download");
      await page.getByRole("link", { name: "Description (TOML)" }).click();
      assert.match(String(await readDownload(await waiting)), /structure = "motor-driver"/);
      await close();
    });
  });
}

describe("a server of three benches", { timeout: SUITE_MS }, () => {
  let server;
  let browser;

  before(async () => {
    const bench = ["paper", "servo-motor", "gear-motor"].map(
      (name) => `${descriptions}${name}.toml`,
    );
    server = await startServer({ speed: 4, bench });
    browser = await launchBrowser();
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  story("rigs stand under their benches; the plan is that of the chosen rig's", async () => {
    const { page, close } = await openPage(browser, server.url);
    await page.getByRole("heading", { name: BENCHES[1].title }).waitFor();
    await becomes(
      async () => bare(await texts(page, ".slider label")),
      ["R1", "R9", "R12", "C8", "Ra", "J", "B", "La"],
    );
    await page.getByLabel("Duration, s").fill("33");
    await page.locator("form select").first().selectOption("servo-motor-sim-1");
    await page.locator("#set-Ke").waitFor();
    await becomes(async () => bare(await texts(page, ".slider label")), BENCHES[0].sliders);
    assert.equal(await page.getByLabel("Duration, s").inputValue(), "20");
    assert.equal(await page.getByLabel("High, V").inputValue(), "2");
    await page.getByRole("button", { name: "Run this experiment" }).click();
    await waitForReview(page);
    await page.locator(".chip", { hasText: "servo-motor-sim-1" }).waitFor();
    await page.getByText(BENCHES[0].title).waitFor();
    const servo = new URL(page.url()).pathname.split("/")[2];

    await page.goto(server.url);
    await page.getByRole("button", { name: "Run the paper's experiment" }).click();
    await page.waitForURL(/\/lab\/.+/);
    await waitForReview(page);
    const paper = new URL(page.url()).pathname.split("/")[2];
    await page.goto(`${server.url}/runs`);
    await page.getByText(/Ra → 23\.2 Ω/).waitFor();
    await page.getByText(/R1 → 100 Ω/).waitFor();
    await page.getByRole("cell", { name: BENCHES[0].title }).waitFor();
    await page.goto(`${server.url}/compare?runs=${servo},${paper}`);
    await page.getByText(/The estimators of these benches predict different signals/).waitFor();
    await page.getByRole("heading", { name: "Ia, A" }).waitFor();
    await page.getByRole("heading", { name: "Um, V" }).waitFor();
    assert.deepEqual(await axe(page), []);
    await close();
  });
});
