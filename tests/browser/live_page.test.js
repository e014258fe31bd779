import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import {
  axe,
  becomes,
  confirmIn,
  finishedPaperRun,
  launchBrowser,
  openPage,
  readDownload,
  SUITE_MS,
  startPaperRun,
  startServer,
  startWire,
  story,
  waitForDrawings,
  waitForReview,
  waitForRunTime,
} from "./support.js";

const CHART = ".plot canvas";
const PNG_MAGIC = "89504e470d0a1a0a";

describe("live page", { timeout: SUITE_MS }, () => {
  let server;
  let browser;

  before(async () => {
    server = await startServer({ speed: 2 });
    browser = await launchBrowser();
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  story(
    "one press shows the experiment, the verdict R1 near 100 ohm, and gives PNG and CSV",
    async () => {
      const { page, close } = await openPage(browser, server.url);
      const id = await startPaperRun(page);
      await page.locator(CHART).first().waitFor();
      await waitForDrawings(page, CHART, 5); // the charts move during the run
      await waitForReview(page);

      const verdict = page.locator(".verdict");
      assert.match(await verdict.locator(".heading").innerText(), /Fault: R1 ↑/);
      const sized = await verdict.locator(".value b").first().innerText();
      const [, value, sigma] = /^([\d.]+) ± ([\d.]+) Ω$/.exec(sized) ?? [];
      assert.ok(Math.abs(Number(value) - 100) < 3, sized);
      assert.ok(Number(sigma) > 0, sized);
      assert.ok((await page.locator("ol .step").count()) >= 2, "the decision path is shown");

      const events = await (
        await page.request.get(`${server.url}/api/v1/runs/${id}/events`)
      ).json();
      const of = (kind) => events.items.find((event) => event.kind === kind);
      assert.equal(of("relay_confirmed").index, 1000, "the fault acts on its sample");
      assert.ok(of("detected").index >= 1000 && of("detected").index <= 1010);

      await page.locator("summary", { hasText: "Download" }).click();
      const csvWaiting = page.waitForEvent("download");
      await page.getByRole("link", { name: "CSV, samples" }).click();
      const csv = (await readDownload(await csvWaiting)).toString();
      const lines = csv.split(/\r?\n/).filter((line) => line && !line.startsWith("#"));
      assert.match(lines[0], /^t_s,uc_v,um_v/);
      assert.equal(lines.length, 2001);
      for (const [figure, scale] of [
        ["Signals", 1],
        ["SWA estimates", 1],
        ["SIA estimates", 2],
        ["Models and measurement", 2],
      ]) {
        const pngWaiting = page.waitForEvent("download");
        await page.getByRole("link", { name: `PNG ${scale}×, ${figure}` }).click();
        const png = await readDownload(await pngWaiting);
        assert.equal(png.subarray(0, 8).toString("hex"), PNG_MAGIC, figure);
        assert.ok(png.length > 10_000, `${figure} has ${png.length} bytes`);
      }
      await close();
    },
  );

  story("a slider is hollow until the rig confirms, and the rig's value is shown", async () => {
    const { page, close } = await openPage(browser, server.url);
    await page.getByLabel("Duration, s").fill("60");
    await page.locator("#set-R1").focus();
    await page.keyboard.press("1");
    await page.getByRole("button", { name: "Run this experiment" }).click();
    await page.waitForURL(/\/lab\/.+/);
    await page.locator(".slider", { has: page.locator("#set-R12") }).waitFor();
    const slider = page.locator(".slider", { has: page.locator("#set-R12") });
    await page.locator("#set-R12:not([disabled])").focus();
    await page.keyboard.press("4");
    await slider.locator("output", { hasText: "2 kΩ" }).waitFor();
    await page.locator(".slider.confirmed #set-R12").waitFor();
    assert.match(await slider.innerText(), /confirmed/);

    await page.locator("#set-R9").focus();
    await page.keyboard.press("2");
    await page.locator(".slider.refused #set-R9").waitFor();
    assert.match(
      await page.locator(".slider", { has: page.locator("#set-R9") }).innerText(),
      /R12 is not nominal/,
    );
    await page.keyboard.press("0");
    await page.locator(".slider.nominal #set-R12").waitFor();
    await page.getByRole("button", { name: /^Stop/ }).click();
    await waitForReview(page);
    assert.match(await page.locator(".state").innerText(), /stopped/);
    await close();
  });

  story("every number of the bench is the server's: the page shows what it is told", async () => {
    const { page, close } = await openPage(browser, `${server.url}/status`);
    await page.route("**/api/v1/benches", async (route) => {
      const answer = await route.fetch();
      const benches = await answer.json();
      const [bench] = benches.items;
      const r1 = bench.components.find((each) => each.symbol === "R1");
      r1.nominal = 4;
      r1.values = [
        { value: 4, line: "Do91" },
        { value: 100, line: "Do92" },
      ];
      bench.parameters.find((each) => each.symbol === "R1").value = 4;
      bench.components = [...bench.components.filter((each) => each !== r1).slice(0, 1), r1];
      bench.healthy.to_s = 9;
      bench.run.max_s = 77;
      bench.published.faults.find((each) => each.value === 100).sia[0] = 8.765;
      await route.fulfill({ response: answer, json: benches });
    });
    await page.reload(); // the page may have asked before the route was there
    await page.getByRole("link", { name: "Lab", exact: true }).click();
    await page.locator("#set-R1").waitFor();
    assert.deepEqual(await page.locator(".slider label").allInnerTexts(), ["R9", "R1"]);
    assert.deepEqual(
      await page
        .locator(".slider", { has: page.locator("#set-R1") })
        .locator(".ticks span")
        .allInnerTexts(),
      ["4 Ω", "100 Ω"],
    );
    await page.getByLabel("Duration, s").fill("78");
    const complaint = await page
      .getByLabel("Duration, s")
      .evaluate((field) => field.validationMessage);
    assert.match(complaint, /\b77\b/);
    await page.getByLabel("Duration, s").fill("20");
    await page.locator("#set-R1").focus();
    await page.keyboard.press("2"); // by itself a plan is of the first component
    await page.getByLabel("Fault at, s").fill("8.5");
    await page.getByText(/in the first 9 s/).waitFor();
    await page.getByLabel("Fault at, s").fill("10");
    await page.getByRole("button", { name: "Run this experiment" }).click();
    await waitForReview(page);
    await page.getByText("R1 = 100 Ω (relay Do92)").waitFor();
    await page.locator(".verdict").getByText("nominal 4 Ω").waitFor();
    await page.getByRole("cell", { name: "8.765" }).waitFor();
    await close();
  });

  story(
    "a page without its bench says so, shows no values, and goes on when it comes",
    async () => {
      const { page, close } = await openPage(browser, server.url, { allow: /ERR_FAILED/ });
      const id = await startPaperRun(page);
      await page.route("**/api/v1/benches**", (route) => route.abort());
      await page.route("**/api/v1/benches/**", (route) => route.abort());
      await page.goto(server.url);
      await page.getByRole("alert").getByText("The server does not answer").waitFor();
      assert.equal(await page.locator(".slider").count(), 0, "no values that nobody has said");
      await page.goto(`${server.url}/lab/${id}`);
      await page.getByRole("heading", { name: "The run could not be loaded" }).waitFor();
      await page.unroute("**/api/v1/benches**");
      await page.unroute("**/api/v1/benches/**");
      await page.getByRole("button", { name: "Try again" }).click();
      await waitForReview(page);
      await page.getByText("R1 = 100 Ω (relay Do0)").waitFor();
      await close();
    },
  );

  story("reload in the middle returns to the run with everything from its start", async () => {
    const { page, close } = await openPage(browser, server.url);
    await startPaperRun(page);
    await waitForRunTime(page, 3);
    await page.reload();
    await page.locator(CHART).first().waitFor();
    await waitForReview(page);
    assert.match(await page.locator(".heading").innerText(), /Fault: R1/);
    await page.keyboard.press("t");
    assert.match(await page.locator(".state").innerText(), /00:20\.0/);
    await close();
  });

  story("a run that ends before its samples and switches came is shown whole", async () => {
    const { page, close } = await openPage(browser, server.url);
    await page.routeWebSocket(/\/ws/, (near) => {
      const far = near.connectToServer();
      far.onMessage((message) => {
        const switched = /"(relay_confirmed|fault_commanded)"/.test(message);
        if (typeof message === "string" && !switched) near.send(message); // nor any samples
      });
    });
    await startPaperRun(page);
    await waitForReview(page);
    assert.match(await page.locator(".state").innerText(), /00:20\.0/);
    await page.getByText("R1 = 100 Ω (relay Do0)").waitFor();
    await waitForDrawings(page, CHART, 1);
    await close();
  });

  story("a value chosen while the samples are late is switched when they come again", async () => {
    const { page, close } = await openPage(browser, server.url);
    await page.addInitScript(() => {
      // a choice waits longer than the test takes, however busy the machine is
      const { setTimeout } = globalThis;
      globalThis.setTimeout = (run, ms) => setTimeout(run, ms === 5000 ? 600_000 : ms);
    });
    await page.reload();
    let late = false;
    await page.routeWebSocket(/\/ws/, (near) => {
      const far = near.connectToServer();
      far.onMessage((message) => {
        if (!late || typeof message === "string") near.send(message); // answers and pongs still come
      });
    });
    await page.getByLabel("Duration, s").fill("600");
    await page.locator("#set-R1").focus();
    await page.keyboard.press("1");
    await page.getByRole("button", { name: "Run this experiment" }).click();
    await page.waitForURL(/\/lab\/.+/);
    await page.locator("#set-R1:not([disabled])").focus();
    await waitForRunTime(page, 6);
    late = true;
    const slider = page.locator(".slider", { has: page.locator("#set-R1") });
    await page.locator(".slider.locked #set-R1:focus").waitFor();
    // a page that stands still for a while is not less late afterwards
    await page.evaluate(() => {
      for (const end = performance.now() + 1500; performance.now() < end; );
    });
    await page.keyboard.press("3");
    await slider.locator("output", { hasText: "→ 56 Ω" }).waitFor();
    assert.equal(await page.locator(".slider.locked #set-R1:focus").count(), 1);
    late = false;
    await slider.and(page.locator(".confirmed")).locator("output", { hasText: /^56 Ω/ }).waitFor();
    await page.keyboard.press("Escape");
    await waitForReview(page);
    await close();
  });

  story(
    "a cut link says so, locks the controls but not Stop, and comes back without a gap",
    async () => {
      const wire = await startWire(server.url);
      const { page, close } = await openPage(browser, wire.url, { allow: /ERR_|WebSocket/ });
      await page.getByLabel("Duration, s").fill("60");
      await page.getByRole("button", { name: "Run this experiment" }).click();
      await page.waitForURL(/\/lab\/.+/);
      await page.locator("#set-R1:not([disabled])").waitFor();
      await waitForRunTime(page, 2);
      wire.cut();
      await page.getByText("reconnecting").waitFor();
      await page.locator("#set-R1[disabled]").waitFor();
      assert.equal(await page.getByRole("button", { name: /^Stop/ }).isDisabled(), false);
      await wire.refusals(2);
      wire.mend();
      await page.locator("#set-R1:not([disabled])").waitFor();
      await page.getByText("· 0 samples missing").waitFor();
      await page.keyboard.press("Escape");
      await waitForReview(page);
      await close();
      wire.close();
    },
  );

  story("a recording uploaded as CSV plays through the live page with its verdict", async () => {
    const { page, close } = await openPage(browser, server.url);
    const id = await startPaperRun(page);
    await waitForReview(page);
    const answer = await page.request.get(`${server.url}/api/v1/runs/${id}/export.csv`);
    // a bench that measures Uc and Um only
    const csv = (await answer.text())
      .split("\n")
      .map((line) => (/^[#t\d]/.test(line) ? line.split(",").slice(0, 3).join(",") : line));
    assert.match(
      csv.find((line) => line.startsWith("t_s")),
      /^t_s,uc_v,um_v$/,
    );
    await page.goto(server.url);
    await page.setInputFiles('input[type="file"]', {
      name: "bench.csv",
      mimeType: "text/csv",
      buffer: Buffer.from(csv.join("\n")),
    });
    const result = page.getByRole("status").filter({ hasText: "bench.csv" });
    await result.getByText("R1 = 100").waitFor();
    await result.getByText("Read: t_s, uc_v, um_v.").waitFor();
    const shown = page.locator("li", { hasText: "bench.csv" });
    await shown.getByText("Fault: R1 ↑ 100").waitFor();
    const titles = () => page.locator(".signals .chart:not(.glass) .title").allInnerTexts();

    await result.getByRole("link", { name: "Open" }).click();
    await page.waitForURL(/\/runs\/rec.+/);
    await page.locator(".heading", { hasText: "Fault: R1 ↑" }).waitFor();
    await becomes(titles, ["Uc, Um, V"], "no chart without a signal");
    await page.goBack();

    await shown.getByRole("button", { name: "Play" }).click();
    await page.waitForURL(/\/lab\/.+/);
    await page.getByText(/^A recording is being played/).waitFor();
    assert.equal(
      await page.locator(".slider").count(),
      0,
      "nothing that looks as if it could be set",
    );
    await waitForRunTime(page, 1);
    assert.deepEqual(await titles(), ["Uc, Um, V"], "no chart without a signal");
    await waitForReview(page);
    assert.deepEqual(await titles(), ["Uc, Um, V"]);
    assert.match(await page.locator(".heading").innerText(), /Fault: R1 ↑/);
    await close();
  });

  story("a CSV without a needed column is refused by name", async () => {
    const { page, close } = await openPage(browser, server.url, { allow: /status of 4/ });
    await page.setInputFiles('input[type="file"]', {
      name: "bad.csv",
      mimeType: "text/csv",
      buffer: Buffer.from("t_s,uc_v\n0,2\n0.01,3\n"),
    });
    await page.getByRole("alert").filter({ hasText: "um_v" }).waitFor();
    await page.getByText("'uc_v' was taken for uc_v; expected").waitFor();
    await close();
  });

  story("an upload is diagnosed again from another stretch, found and deleted", async () => {
    const { run, guest } = await finishedPaperRun(browser, server);
    const { page, close } = await openPage(browser, server.url, { storageState: guest });
    const file = await page.request.get(`${server.url}/api/v1/runs/${run}/export.csv`);
    const csv = await file.body();
    await page.setInputFiles('input[type="file"]', {
      name: "again.csv",
      mimeType: "text/csv",
      buffer: csv,
    });
    const result = page.getByRole("status").filter({ hasText: "again.csv" });
    await result.getByText("R1 = 100").waitFor();
    await page.getByText("How it is diagnosed").click();
    await page.getByLabel("Healthy from, s").fill("1");
    await page.getByLabel("to, s", { exact: true }).fill("1.5");
    await result.getByRole("button", { name: "Diagnose again" }).click();
    await result.getByText("The healthy beginning was too short").waitFor();
    assert.deepEqual(await axe(page), []);

    await page.getByRole("link", { name: "All uploads" }).click();
    const rows = page.locator("tbody tr").filter({ hasText: "again.csv" });
    await becomes(() => rows.count(), 1, "the first one was replaced");
    await rows.getByRole("button", { name: "Delete" }).click();
    await confirmIn(page);
    await rows.waitFor({ state: "detached" });
    await close();
  });

  story("an unknown run says so and leads back", async () => {
    const { page, close } = await openPage(browser, `${server.url}/runs/no-such-run`, {
      allow: /status of 404/,
    });
    await page.getByRole("heading", { name: "There is no such run" }).waitFor();
    await page.getByRole("link", { name: "To the start page" }).click();
    await page.getByRole("button", { name: "Run the paper's experiment" }).waitFor();
    await close();
  });
});
