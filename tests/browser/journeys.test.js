// The whole way of each role, as one goes it. The operator's is in operator.test.js.
import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import { makeWorld, PASSWORD, pageOf } from "./lab_world.js";
import { difference, inkOf, pagesOf, wordsOf } from "./paper.js";
import {
  confirmIn,
  holdRequests,
  launchBrowser,
  openPage,
  readDownload,
  SUITE_MS,
  startPaperRun,
  startServer,
  story,
  waitForReview,
} from "./support.js";

const MARGIN_MM = 5;

describe("journeys", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let world;
  let student;
  let teacher;

  before(async () => {
    server = await startServer({ speed: 8, benches: 1 });
    browser = await launchBrowser();
    world = await makeWorld(server);
    [student, teacher] = await Promise.all([
      world.user("pera", "Pera", "student"),
      world.user("vera", "Vera", "instructor"),
    ]);
    await world.benchesReady(1);
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  async function signIn(page, login) {
    await page.getByRole("link", { name: "Sign in" }).click();
    await page.getByLabel("Login").fill(login);
    await page.getByLabel("Password").fill(PASSWORD);
    await page.getByRole("main").getByRole("button", { name: "Sign in" }).click();
    await page.getByRole("heading", { name: "My lab" }).waitFor();
  }

  story("a guest gets a verdict, and its report on paper", async () => {
    const { page, close } = await openPage(browser, server.url);
    const run = await startPaperRun(page);
    await page.locator(".verdict .heading", { hasText: "Fault: R1" }).waitFor();
    await waitForReview(page);
    await page.locator("summary", { hasText: "Download" }).click();
    const address = await page.getByRole("link", { name: /^Report/ }).getAttribute("href");
    // what the page leads to is, pixel for pixel, what a program gets
    const [report, other] = await Promise.all([
      page.request.get(server.url + address).then((each) => each.body()),
      fetch(`${server.url}/api/v1/runs/${run}/report.pdf`).then((each) => each.arrayBuffer()),
    ]);
    const words = wordsOf(report);
    assert.match(words, /R1/);
    assert.ok(words.includes(run), "the report names its run");
    const [here, there] = [pagesOf(report), pagesOf(Buffer.from(other))];
    assert.equal(here.length, there.length);
    here.forEach((paper, at) => {
      assert.ok(difference(paper, there[at]) < 0.001, `page ${at + 1} is another`);
      assert.ok(inkOf(paper) > 1000, `page ${at + 1} is empty`);
      assert.equal(inkOf(paper, MARGIN_MM), 0, `page ${at + 1} reaches the edge of the paper`);
    });
    // and what the browser prints has all of it on the paper
    await page.locator(".plot canvas").nth(6).waitFor({ state: "attached" });
    for (const paper of pagesOf(await page.pdf({ format: "A4" }))) {
      assert.ok(inkOf(paper) > 500);
      assert.equal(inkOf(paper, MARGIN_MM), 0);
    }
    await close();
  });

  story("nothing that can be pressed moves away: it waits for what stands above it", async () => {
    const { page, close } = await openPage(browser, `${server.url}/help`);
    const list = await holdRequests(page, /\/api\/v1\/rigs$/);
    await page.goto(server.url);
    await page
      .getByRole("button", { name: "Run the paper's experiment", disabled: false })
      .waitFor();
    assert.ok(await page.getByRole("button", { name: "Run this experiment" }).isDisabled());
    assert.equal(
      await page.getByRole("heading", { name: "Your own recording" }).isVisible(),
      false,
    );
    await list.letGo();
    await page.getByRole("button", { name: "Run this experiment", disabled: false }).waitFor();
    await page.getByRole("heading", { name: "Your own recording" }).waitFor();
    await close();
  });

  story("a student takes a bench, breaks it, stops, and compares two runs", async () => {
    const { page, close } = await openPage(browser, server.url);
    await signIn(page, "pera");
    await page.getByRole("button", { name: "Ask for a rig now" }).click();
    await page.getByRole("button", { name: "Accept" }).click();
    await page.getByRole("link", { name: "Use the rig" }).click();
    await page.getByLabel("Duration, s").fill("600");
    await page.locator("#set-R1").focus();
    await page.keyboard.press("1"); // nothing is planned
    await page.getByRole("button", { name: "Run this experiment" }).click();
    await page.waitForURL(/\/lab\/.+/);
    await page.locator("#set-R12:not([disabled])").focus();
    await page.keyboard.press("2");
    await page.locator(".slider.confirmed #set-R12").waitFor();
    await page.locator(".verdict .heading", { hasText: "R9 or R12" }).waitFor();
    await page.getByRole("button", { name: /^Stop/ }).click();
    await waitForReview(page);

    await page.getByLabel("Duration, s").fill("20");
    const first = new URL(page.url()).pathname;
    await page.getByText(/^bench-1: /).waitFor(); // the next run is on the bench, too
    await page.locator(".left").getByRole("button", { name: "Run" }).click();
    await page.waitForURL((url) => url.pathname.startsWith("/lab/") && url.pathname !== first);
    await waitForReview(page);
    assert.equal(await page.locator(".chip.rig").innerText(), "bench-1");
    await page.getByRole("link", { name: "Runs", exact: true }).click();
    const boxes = page.getByRole("checkbox", { name: /^Compare run/ });
    await boxes.nth(1).waitFor();
    for (const at of [0, 1]) await boxes.nth(at).check();
    await page.getByRole("link", { name: "Compare 2 runs" }).click();
    const csv = page.getByRole("button", { name: "CSV Um, V" });
    const [file] = await Promise.all([page.waitForEvent("download"), csv.click()]);
    assert.ok((await readDownload(file)).length > 10_000);

    await page.getByRole("link", { name: "My lab" }).first().click();
    await page.getByRole("button", { name: "End session" }).click();
    await confirmIn(page);
    await page.getByRole("button", { name: "Ask for a rig now" }).waitFor();
    await close();
  });

  story("an instructor makes a course and a fault set, which its student then runs", async () => {
    const { page, close } = await pageOf(browser, server, teacher, "/teach");
    const courses = page.locator("section.card", { hasText: "Courses" });
    await courses.getByLabel("Name").fill("Diagnosis 1");
    await courses.getByRole("button", { name: "New course" }).click();
    await courses.getByRole("button", { name: /, Diagnosis 1$/ }).click();
    await courses.getByLabel(/the login, then the name/).fill("login,name\npera,Pera\n");
    await courses.getByRole("button", { name: "Look at the list first" }).click();
    await courses.getByRole("button", { name: "Add all 1" }).click();
    await courses.getByText(/^pera \(invited/).waitFor();

    const set = page.getByRole("form", { name: "New fault set" });
    await set.getByRole("combobox", { name: "Course" }).selectOption("Diagnosis 1");
    await set.getByLabel("Name").fill("What is it?");
    await set.getByLabel("Component").selectOption("C8");
    await set.getByRole("button", { name: "Save" }).click();
    await page.getByRole("listitem").filter({ hasText: "What is it?" }).first().waitFor();
    await close();

    const theirs = await pageOf(browser, server, student, "/my");
    await theirs.page.getByRole("button", { name: "Join the course" }).click();
    await theirs.page.getByRole("button", { name: "Join the course" }).waitFor({ state: "hidden" });
    await theirs.page.getByRole("link", { name: "Lab", exact: true }).click();
    await theirs.page.getByLabel("Fault set").selectOption({ label: "What is it?" });
    await theirs.page.getByRole("button", { name: "Run this experiment" }).click();
    await waitForReview(theirs.page);
    assert.match(await theirs.page.locator(".verdict .heading").innerText(), /C8/);
    await theirs.close();

    // and the instructor finds the run in the course
    const again = await pageOf(browser, server, teacher, "/runs");
    await again.page.getByLabel("Whose runs").selectOption("Diagnosis 1");
    await again.page.locator("tbody tr", { hasText: "C8" }).filter({ hasText: "Pera" }).waitFor();
    await again.close();
  });
});
