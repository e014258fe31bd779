import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import {
  axe,
  launchBrowser,
  openPage,
  SUITE_MS,
  settled,
  startServer,
  story,
  waitForReview,
} from "./support.js";

const PASSWORD = "correct horse battery";

describe("lab", { timeout: SUITE_MS }, () => {
  let server;
  let browser;

  before(async () => {
    server = await startServer({ speed: 20 });
    browser = await launchBrowser();
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });

  async function setPassword(page, url) {
    await page.goto(url);
    await page.getByLabel("New password").fill(PASSWORD);
    await page.getByLabel("Repeat the password").fill(PASSWORD);
    await page.getByText(/^For the account of /).waitFor();
    await page.getByRole("button", { name: "Save and sign in" }).click();
    await page.getByRole("heading", { name: "My lab" }).waitFor();
  }

  story(
    "first link, admin, new instructor, fault set, run with it, sweep as jobs, key, sign out",
    async () => {
      const token = /reset\?token=([\w-]+)/.exec(server.output())?.[1];
      assert.ok(token, `the first start prints a link:\n${server.output()}`);
      const { page, close } = await openPage(browser, server.url);
      await setPassword(page, `${server.url}/reset?token=${token}`);

      await page.getByRole("link", { name: "Operate" }).click();
      await page.getByRole("heading", { name: "Users" }).waitFor();
      await page.locator("summary", { hasText: "Add user" }).click();
      await page.getByLabel("Login", { exact: true }).fill("teacher");
      await page.getByLabel("Name", { exact: true }).fill("A Teacher");
      await page.locator("details form").getByRole("combobox").selectOption("instructor");
      await page.getByRole("button", { name: "Add user" }).click();
      const link = await page.locator("code").innerText();
      const added = page.getByRole("listitem").filter({ hasText: "A Teacher" });
      await added.getByText("no password yet").waitFor();
      await added.getByRole("combobox", { name: "Role teacher" }).waitFor();
      assert.deepEqual(await axe(page), []);
      // What the page still loads comes first: after the sign-out it would be refused.
      const asked = [];
      page.on("request", (request) => asked.push(new URL(request.url()).pathname));
      let release;
      const held = new Promise((resolve) => {
        release = resolve;
      });
      await page.route("**/api/v1/api-keys*", (route) => held.then(() => route.continue()));
      await page.getByRole("link", { name: "admin" }).click();
      await page.getByRole("button", { name: "Sign out" }).click();
      release();
      await page.getByRole("link", { name: "Sign in" }).waitFor();
      assert.ok(asked.includes("/api/v1/calendar-link"), asked.join());
      assert.ok(
        asked.indexOf("/api/v1/auth/logout") > asked.indexOf("/api/v1/calendar-link"),
        asked.join(),
      );
      await page.unroute("**/api/v1/api-keys*");

      await setPassword(page, link);
      assert.equal(await page.getByRole("link", { name: "Operate" }).count(), 0);
      assert.deepEqual(await axe(page), []);

      await page.getByRole("link", { name: "Teach", exact: true }).click();
      const set = page.getByRole("form", { name: "New fault set" });
      await set.getByLabel("Name").fill("Gain faults");
      await set.getByLabel("Component").selectOption("R12");
      await set.getByRole("button", { name: "Save" }).click();
      await page.getByText("R12 → 5.6 kΩ @ 10 s").waitFor();
      await page.getByText("Which faults can be distinguished?").click();
      await page.getByRole("row", { name: "R12 = 5.6 kΩ yes R9" }).waitFor();
      await page.getByLabel("Measured").selectOption("all");
      await page.getByLabel("Time after the fault").selectOption("2 s");
      const png = await page.getByRole("link", { name: "PNG" }).getAttribute("href");
      assert.match(png, /isolability\.png\?channels=all&window_samples=200$/);
      const picture = await page.request.get(server.url + png);
      assert.equal(picture.headers()["content-type"], "image/png");
      assert.deepEqual(await axe(page), []);

      await page.getByRole("link", { name: "Lab", exact: true }).click();
      await page.getByLabel("Fault set").selectOption({ label: "Gain faults" });
      await page.getByRole("button", { name: "Run this experiment" }).click();
      await waitForReview(page);
      assert.match(await page.locator(".heading").innerText(), /R12/);

      await page.getByRole("link", { name: "Jobs" }).click();
      await page.getByRole("button", { name: "Submit 3 runs" }).click();
      const jobs = page.getByRole("region", { name: "My jobs" }).getByRole("listitem");
      await jobs.filter({ hasText: "sweep" }).nth(2).waitFor();
      for (const value of ["10 Ω", "56 Ω", "100 Ω"]) {
        await jobs.getByText(`R1 ${value}`, { exact: true }).waitFor();
      }
      assert.deepEqual(await axe(page), []);

      await page.getByRole("link", { name: "A Teacher" }).click();
      await page.getByLabel("Name").fill("script");
      await page.getByRole("button", { name: "New key" }).click();
      const key = await page.locator("code").innerText();
      const me = await fetch(`${server.url}/api/v1/auth/me`, {
        headers: { Authorization: `Bearer ${key}` },
      });
      assert.equal((await me.json()).login, "teacher");
      assert.deepEqual(await axe(page), []);
      await page.getByRole("button", { name: "Sign out" }).click();
      await page.getByRole("link", { name: "Sign in" }).waitFor();
      await close();
    },
  );

  story("a wrong password is refused in words, and nobody is signed in", async () => {
    const { page, close } = await openPage(browser, `${server.url}/signin`, {
      allow: /status of 401/,
    });
    await page.getByLabel("Login").fill("admin");
    await page.getByLabel("Password").fill("wrong wrong wrong");
    await page.getByRole("main").getByRole("button", { name: "Sign in" }).click();
    await page.getByRole("alert").waitFor();
    assert.ok((await page.getByRole("alert").innerText()).length > 10);
    assert.equal(await page.getByRole("link", { name: "My lab" }).count(), 0);
    await close();
  });

  story("a guest who opens the lab's pages is asked to sign in, and nothing breaks", async () => {
    for (const path of ["/my", "/book", "/teach", "/admin", "/jobs", "/account"]) {
      const { page, close } = await openPage(browser, server.url + path, {
        allow: /status of 40[13]/,
      });
      await settled(page);
      assert.deepEqual(await axe(page), [], path);
      await close();
    }
  });
});
