// Signing in at a provider: oidc-provider from npm, configured as at a university, and a provider
// that violates the protocol. Both are on loopback, which only `insecure_loopback` allows.
import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import { hostileProvider } from "../oidc_provider/hostile_provider.js";
import { listen } from "../oidc_provider/listener.js";
import { realProvider } from "../oidc_provider/real_provider.js";
import { makeWorld } from "./lab_world.js";
import { axe, launchBrowser, PATIENCE_MS, SUITE_MS, startServer, story } from "./support.js";

const table = (id, label, issuer) => `
[[oidc]]
id = "${id}"
label = "${label}"
issuer = "${issuer}"
client_id = "faultlab"
client_secret_env = "FAULTLAB_TEST_SECRET"
insecure_loopback = true
`;

describe("signing in at a provider", { timeout: SUITE_MS }, () => {
  let server;
  let world;
  let real;
  let evil;
  let hostile;
  let browser;

  before(async () => {
    process.env.FAULTLAB_TEST_SECRET = "a secret, with: signs & %2B+";
    real = await listen();
    evil = await listen();
    const restricted = `${table("staff", "Staff", real.url)}allowed_domains = ["elsewhere.example"]\n`;
    server = await startServer({
      settings: table("uni", "University", real.url) + table("evil", "Evil", evil.url) + restricted,
    });
    const callback = (id) => `${server.url}/api/v1/auth/oidc/${id}/callback`;
    real.serve(
      await realProvider(real.url, {
        client_id: "faultlab",
        client_secret: process.env.FAULTLAB_TEST_SECRET,
        redirect_uris: [callback("uni"), callback("staff")],
      }),
    );
    hostile = await hostileProvider(evil.url);
    evil.serve(hostile.handler);
    world = await makeWorld(server);
    browser = await launchBrowser();
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
    await real?.stop();
    await evil?.stop();
  });

  /** A client without a page: keeps cookies by host and follows no redirect automatically. */
  function visitor() {
    const jars = new Map();
    return {
      jars,
      async go(url, init = {}) {
        const { host } = new URL(url);
        const jar = jars.get(host) ?? jars.set(host, new Map()).get(host);
        const answer = await fetch(url, {
          redirect: "manual",
          ...init,
          headers: { Cookie: [...jar].map((pair) => pair.join("=")).join("; "), ...init.headers },
        });
        for (const line of answer.headers.getSetCookie()) {
          const [name, ...value] = line.split(";")[0].split("=");
          if (/max-age=0|expires=Thu, 01 Jan 1970/i.test(line)) jar.delete(name);
          else jar.set(name, value.join("="));
        }
        const to = answer.headers.get("location");
        return { status: answer.status, to: to && new URL(to, url).href, answer };
      },
      /** The cookies of the server under test. */
      get here() {
        return jars.get(new URL(server.url).host) ?? new Map();
      },
    };
  }
  const start = (who, id, next = "") =>
    who.go(`${server.url}/api/v1/auth/oidc/${id}/start?next=${encodeURIComponent(next)}`);
  /** From the sign-in button to the address of the callback, which is not opened yet. */
  async function arrive(who, next) {
    const left = await start(who, "evil", next);
    assert.equal(left.status, 303);
    return (await who.go(left.to)).to;
  }
  const nameOf = async (who) =>
    (await (await who.go(`${server.url}/api/v1/auth/me`)).answer.json()).login;

  function refused(answer, who, reason) {
    assert.equal(answer.status, 303);
    assert.equal(answer.to, `${server.url}/signin?failed=${reason}`);
    assert.equal(who.here.has("faultlab_session"), false, "nobody is signed in");
  }

  async function openSignIn(path, options = {}) {
    const context = await browser.newContext({ locale: "en", ...options });
    const page = await context.newPage();
    page.setDefaultTimeout(PATIENCE_MS);
    await page.goto(server.url + path);
    return { page, context };
  }

  /** Signs in as `name` at a provider, whose page may still be on its way; ours has a field "Name" too. */
  async function signInAtProvider(page, name) {
    await page.waitForURL(/\/interaction\//);
    await page.getByLabel("Name").fill(name);
    await page.getByRole("button", { name: "Sign in" }).click();
  }

  story("a student signs in by the page's button, and again as the same person", async () => {
    for (const time of ["first", "second"]) {
      const { page, context } = await openSignIn("/signin?next=/account");
      assert.deepEqual(await axe(page), []);
      await page.getByRole("link", { name: "Sign in with University" }).click();
      await signInAtProvider(page, "ann");
      await page.getByRole("heading", { name: "Ana Anić" }).waitFor();
      assert.equal(page.url(), `${server.url}/account`, time);
      const cookies = await context.cookies(server.url);
      const session = cookies.find((cookie) => cookie.name === "faultlab_session");
      assert.ok(session.httpOnly && session.sameSite === "Lax");
      assert.ok(!cookies.some((cookie) => cookie.name === "faultlab_login"), "it is used up");
      await context.close();
    }
    const { json } = await world.call(world.admin, "GET", "/users");
    const anns = json.items.filter((user) => user.login === "ann");
    assert.deepEqual(
      anns.map((user) => [user.role, user.has_password]),
      [["student", false]],
    );
    const { json: log } = await world.call(world.admin, "GET", "/audit");
    assert.ok(log.items.some((line) => line.verb === "sign_in" && / by uni$/.test(line.detail)));
  });

  story("the page says in plain words why not", async () => {
    const { page, context } = await openSignIn("/signin");
    const tryAs = async (button, name) => {
      await page.goto(`${server.url}/signin`);
      await page.getByRole("link", { name: button }).click();
      await signInAtProvider(page, name);
      const said = await page.getByRole("alert").innerText();
      await context.clearCookies();
      return said;
    };
    assert.match(await tryAs("Sign in with University", "nobody"), /was not allowed/);
    assert.match(await tryAs("Sign in with Staff", "ann"), /does not accept/);
    // An existing account is never found by login or e-mail, in particular not the admin's.
    assert.match(await tryAs("Sign in with University", "admin"), /with your login exists/);
    await context.close();
  });

  story("the owner of an account adds a provider to it", async () => {
    await world.user("bob", "Bob", "student");
    const { page, context } = await openSignIn("/signin?next=/account");
    await page.getByLabel("Login").fill("bob");
    await page.getByLabel("Password").fill("correct horse battery");
    await page.getByRole("button", { name: "Sign in" }).click();
    await page.getByRole("button", { name: "Add University" }).click();
    await signInAtProvider(page, "stranger");
    await page.getByRole("button", { name: "Remove University" }).waitFor();
    await context.close();

    const again = await openSignIn("/signin?next=/account");
    await again.page.getByRole("link", { name: "Sign in with University" }).click();
    await signInAtProvider(again.page, "stranger");
    await again.page.getByRole("heading", { name: "Bob" }).waitFor();
    await again.context.close();
  });

  story("a provider that does nothing wrong is taken, and its answer counts once", async () => {
    const who = visitor();
    const callback = await arrive(who, "/runs?mine=1");
    const kept = new Map(who.here);
    const first = await who.go(callback);
    assert.equal(first.to, `${server.url}/runs?mine=1`);
    assert.equal(await nameOf(who), "hostile.ann");
    assert.ok(!who.here.has("faultlab_login"));
    // Again in the same browser, which has forgotten the sign-in.
    who.here.delete("faultlab_session");
    refused(await who.go(callback), who, "oidc_elsewhere");
    // And with a cookie that was kept, at a provider that accepts a code twice.
    const given = hostile.tokensGiven;
    for (const [name, value] of kept) who.here.set(name, value);
    refused(await who.go(callback), who, "oidc_elsewhere");
    assert.equal(hostile.tokensGiven, given + 1, "the provider would have let it pass");
  });

  story("a sign-in begun in another browser is refused", async () => {
    const attacker = visitor();
    const callback = await arrive(attacker);
    const victim = visitor();
    refused(await victim.go(callback), victim, "oidc_elsewhere");
    // Also when the victim has begun a sign-in, or comes with a code of another provider.
    await start(victim, "evil");
    refused(await victim.go(callback), victim, "oidc_elsewhere");
    const own = visitor();
    const mixed = (await arrive(own)).replace("/oidc/evil/", "/oidc/uni/");
    refused(await own.go(mixed), own, "oidc_elsewhere");
  });

  story("a session that was there before is not the one after", async () => {
    const who = visitor();
    who.go(`${server.url}/signin`);
    const callback = await arrive(who);
    who.here.set("faultlab_session", "fls_chosen-by-an-attacker");
    await who.go(callback);
    assert.notEqual(who.here.get("faultlab_session"), "fls_chosen-by-an-attacker");
    assert.equal(await nameOf(who), "hostile.ann");
  });

  story("what a hostile provider signs or says wrongly is refused", async () => {
    const modes = [
      "none",
      "confused key",
      "another key",
      "unknown kid",
      "last character",
      "crit",
      "issuer",
      "audience",
      "azp",
      "nonce",
      "expired",
      "userinfo",
      "mixed up",
      "silent issuer",
      "redirect",
      "flood",
    ];
    try {
      for (const mode of modes) {
        hostile.mode = mode;
        const who = visitor();
        refused(await who.go(await arrive(who)), who, "oidc_failed");
      }
    } finally {
      hostile.mode = "";
    }
    const who = visitor();
    await who.go(await arrive(who));
    assert.equal(await nameOf(who), "hostile.ann", "and nothing else was wrong");
  });

  story("nobody is led away from this site", async () => {
    for (const next of [
      "https://evil.example",
      "//evil.example",
      "/\\evil.example",
      "/\t/evil.example",
    ]) {
      const who = visitor();
      assert.equal((await who.go(await arrive(who, next))).to, `${server.url}/my`, next);
    }
  });
});
