// What becomes of runs: named, found again, compared, shared.
import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import { makeWorld, pageOf } from "./lab_world.js";
import {
  axe,
  launchBrowser,
  openPage,
  readDownload,
  SUITE_MS,
  settled,
  startServer,
  story,
  waitForReview,
} from "./support.js";

describe("runs", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let world;
  let student;
  let teacher;
  let stranger;
  let runs;

  before(async () => {
    server = await startServer({ speed: 0 });
    browser = await launchBrowser();
    world = await makeWorld(server);
    [student, stranger, teacher] = await Promise.all([
      world.user("pera", "Pera", "student"),
      world.user("mika", "Mika", "student"),
      world.user("vera", "Vera", "instructor"),
    ]);
    const course = await world.course(teacher, "Diagnosis", [student, stranger]);
    await world.join(student, course);
    runs = [];
    for (const fault of [
      { component: "R1", value: 100, at_s: 10 },
      { component: "R12", value: 5600, at_s: 8 },
      null,
    ]) {
      runs.push(await world.run(student, { duration_s: 20, faults: fault ? [fault] : [] }));
    }
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  const rowOf = (page, words) => page.locator("tbody tr").filter({ hasText: words });

  story("a run gets a name, a note and a star, and is found by each of them", async () => {
    const { page, close } = await pageOf(browser, server, student, "/runs");
    await rowOf(page, runs[2]).waitFor();
    assert.equal(await page.locator("tbody tr").count(), 3);
    await page.getByRole("button", { name: `Name and note of run ${runs[0]}` }).click();
    await page.getByLabel("Name", { exact: true }).fill("Broken R1");
    await page.getByLabel("Note", { exact: true }).fill("to hand in");
    await page.getByRole("button", { name: "Save" }).click();
    await page.getByRole("link", { name: "Broken R1", exact: true }).waitFor();
    await page.getByRole("button", { name: "Star for run Broken R1" }).click();
    await page.locator('.star[aria-pressed="true"]').waitFor();

    await page.reload();
    await page.locator('.star[aria-pressed="true"]').waitFor();
    const only = async (words) => {
      await rowOf(page, words).waitFor();
      await page.waitForFunction(() => document.querySelectorAll("tbody tr").length === 1);
    };
    await page.getByLabel("Search").fill("hand in");
    await only("Broken R1");
    await page.getByLabel("Search").fill("no such words");
    await page.locator("tbody tr").first().waitFor({ state: "detached" });
    await page.getByLabel("Search").fill("");
    await page.getByLabel("starred only").check();
    await only("Broken R1");
    await page.getByLabel("starred only").uncheck();
    await page.getByLabel("Verdict").selectOption({ label: "No fault" });
    await only(runs[2]);
    await close();
  });

  story("two runs are compared from their faults on, with cursors, zoom and files", async () => {
    const { page, close } = await pageOf(browser, server, student, "/runs");
    for (const run of ["Broken R1", runs[1]]) {
      await page.getByRole("checkbox", { name: `Compare run ${run}` }).check();
    }
    await page.getByRole("link", { name: "Compare 2 runs" }).click();
    const table = page.locator("table").first();
    await table.getByRole("row", { name: /Broken R1 .*R1 → 100 Ω.*Fault: R1/ }).waitFor();
    await table.getByRole("row", { name: /R12 → 5.6 kΩ @ 8 s.*Fault: R9 or R12/ }).waitFor();

    // both runs leave their healthy b0 at 0, though one broke at 10 s and the other at 8 s
    await page.getByLabel("Time of cursor A").fill("-1");
    await page.getByLabel("Time of cursor B").fill("4");
    await page.getByLabel("Time of cursor B").press("Tab");
    const values = async (name) => {
      const rows = page.getByRole("table", { name: new RegExp(`${name}$`) }).locator("tbody tr");
      await rows.nth(1).waitFor();
      return (await rows.allInnerTexts()).map((row) =>
        row
          .split("\t")
          .slice(1)
          .map((each) => Number(each.replace("−", "-"))),
      );
    };
    const before = await values("b0");
    for (const [a, b, change] of before) {
      assert.ok(Math.abs(a - 2.39) < 0.02 && b < 1.7, `b0 goes from ${a} to ${b}`);
      assert.ok(Math.abs(b - a - change) < 0.002, `${change}`);
    }
    assert.deepEqual(await axe(page), []);
    await page.getByRole("checkbox", { name: /align/ }).uncheck();
    await page.getByLabel("Time of cursor A").fill("9.5");
    await page.getByLabel("Time of cursor A").press("Tab");
    const unaligned = await values("b0");
    assert.ok(unaligned[0][0] > 2.3, "the first is healthy at 9.5 s");
    assert.ok(unaligned[1][0] < 1.7, "the second is not");
    await page.getByRole("checkbox", { name: /align/ }).check();

    // a click moves the nearer cursor, here B, to the middle: the fault
    const plot = page.locator(".u-over").first();
    const box = await plot.boundingBox();
    await plot.click({ position: { x: (box.width * 10) / 22, y: box.height / 2 } });
    await page.waitForFunction(() => {
      const [a, b] = [...document.querySelectorAll(".cursor input")].map((each) =>
        Number(each.value.replace("−", "-")),
      );
      return Math.min(Math.abs(a), Math.abs(b)) < 0.5;
    });

    const download = async (press) => {
      const [file] = await Promise.all([page.waitForEvent("download"), press()]);
      return { name: file.suggestedFilename(), bytes: await readDownload(file) };
    };
    const csvOf = async () => {
      const { name, bytes } = await download(() =>
        page.getByRole("button", { name: "CSV Um, V" }).click(),
      );
      assert.match(name, /^faultlab-compare-Um.*\.csv$/);
      const [header, ...lines] = bytes.toString().trim().split("\n");
      assert.equal(header, `t_s,"Broken R1","${runs[1]}"`);
      return lines.map((line) => line.split(","));
    };
    const whole = await csvOf();
    assert.equal(Number(whole[0][0]), -10);
    assert.equal(whole[0][2], "", "the second run was not there 10 s before its fault");
    assert.ok(Number(whole.at(-1)[0]) > 11.9);

    await page.mouse.move(box.x + box.width * 0.5, box.y + 40);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.6, box.y + 40, { steps: 4 });
    await page.mouse.up();
    await page.getByRole("button", { name: "Whole run" }).waitFor();
    const part = await csvOf();
    assert.ok(part.length < whole.length / 5, `${part.length} of ${whole.length} lines`);
    await page.getByRole("button", { name: "Whole run" }).click();

    const shown = await download(() => page.getByRole("button", { name: "PNG Um, V" }).click());
    assert.match(shown.name, /\.png$/);
    assert.equal(shown.bytes.subarray(1, 4).toString(), "PNG");
    const figure = await page.getByRole("link", { name: "Figure (PNG)" }).getAttribute("href");
    const drawn = await page.request.get(server.url + figure);
    assert.equal(drawn.headers()["content-type"], "image/png");
    await close();
  });

  story(
    "the address of a run opens it for its teacher, not for a stranger or a guest",
    async () => {
      const mine = await pageOf(browser, server, student, "/runs");
      await mine.page.getByRole("button", { name: /^Name and note of run Broken R1/ }).click();
      const address = await mine.page.getByLabel(/^Link to this run/).inputValue();
      assert.ok(address.endsWith(`/runs/${runs[0]}`), address);
      await mine.close();
      const path = new URL(address).pathname;

      const theirs = await pageOf(browser, server, teacher, path);
      await theirs.page.getByRole("heading", { name: "Verdict" }).waitFor();
      assert.match(await theirs.page.locator(".verdict .heading").innerText(), /Fault: R1/);
      await theirs.close();
      const allow = /status of 40[134]/;
      const refused = [
        [await pageOf(browser, server, stranger, path, { allow }), "There is no such run"],
        [await openPage(browser, server.url + path, { allow }), "Sign in to see this page"],
      ];
      for (const [opened, words] of refused) {
        await opened.page.getByRole("heading", { name: words }).waitFor();
        await settled(opened.page);
        assert.doesNotMatch(await opened.page.innerText("main"), /R1 → 100/);
        await opened.close();
      }
      for (const file of ["export.csv", "report.pdf", "frames"]) {
        const address = `${server.url}/api/v1/runs/${runs[0]}/${file}`;
        const { status } = await fetch(address, { headers: { Cookie: stranger.cookie } });
        assert.ok([403, 404].includes(status), `${file}: ${status}`);
      }
    },
  );

  story("all methods are compared on a run, on the same samples", async () => {
    const { page, close } = await pageOf(browser, server, student, `/runs/${runs[0]}`);
    await waitForReview(page);
    await page.getByRole("button", { name: "Methods" }).click();
    await page.getByRole("button", { name: "Compare all methods on this run" }).click();
    const row = (name) => page.getByRole("row", { name: new RegExp(`^${name} `) });
    await row("faultlab").waitFor(); // the last of them
    assert.match(
      await row("faultlab").innerText(),
      /10\.0\d s \+0\.0\d s\s+R1\s=\s10[01]\sΩ\s+0\.20 s after the alarm/,
    );
    assert.match(await row("Parity equations").innerText(), /cannot say how large/);
    await page.getByText("Compare all methods on this run").waitFor();
    assert.deepEqual(await axe(page), []);
    await page.getByRole("link", { name: "What they are" }).click();
    await page.getByRole("heading", { name: "Methods of the literature" }).waitFor();
    await page.getByText("Unscented Kalman filters, a bank", { exact: true }).waitFor();
    assert.deepEqual(await axe(page), []);
    await close();

    const phone = await pageOf(browser, server, student, `/runs/${runs[0]}`, {
      viewport: { width: 390, height: 800 },
    });
    await waitForReview(phone.page);
    await phone.page.getByRole("button", { name: "Methods" }).click();
    await phone.page.getByRole("button", { name: "Compare all methods on this run" }).waitFor();
    assert.ok((await phone.page.evaluate(() => document.documentElement.scrollWidth)) <= 390);
    await phone.close();
  });
});
