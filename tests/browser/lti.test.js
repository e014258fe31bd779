// Links of a learning platform (LTI 1.3) lead into an exercise, and its grades go back (AGS 2.0).
import assert from "node:assert/strict";
import { after, before, describe } from "node:test";
import { MEMBER, startPlatform } from "../lti_platform/platform.js";
import { makeWorld, pageOf } from "./lab_world.js";
import {
  axe,
  confirmIn,
  launchBrowser,
  SUITE_MS,
  startServer,
  story,
  temporaryDirectory,
  until,
} from "./support.js";

const LATE = { name: "Exercise 2", reveal: "due", attempts: 1, plan: { duration_s: 12 } };
const LTI = "https://purl.imsglobal.org/spec/lti/claim/";

describe("learning platforms", { timeout: SUITE_MS }, () => {
  let server;
  let browser;
  let world;
  let teacher;
  let platform;
  let registered;
  let exercise;
  let data;
  const started = (more = {}) => ({
    speed: 200,
    data: data.path,
    settings: "[lti]\ninsecure_loopback = true\n",
    ...more,
  });

  before(async () => {
    platform = await startPlatform({ host: "localhost" });
    await platform.newKey("k2");
    data = temporaryDirectory();
    server = await startServer(started());
    world = await makeWorld(server);
    teacher = await world.user("teacher", "A Teacher", "instructor");
    const { json: list } = await world.call(world.admin, "GET", "/lti/platforms");
    platform.meet(list.tool);
    ({ json: registered } = await world.call(
      world.admin,
      "POST",
      "/lti/platforms",
      platform.registration(),
    ));
    const { json: course } = await world.call(teacher, "POST", "/courses", { name: "Drives" });
    const { json: set } = await world.call(teacher, "POST", "/fault-sets", {
      name: "pool",
      pool: { items: [{ component: "R9", low: 15000, high: 33000, onset_from_s: 8 }] },
    });
    ({ json: exercise } = await world.call(teacher, "POST", "/assignments", {
      name: "Exercise 1",
      course: course.id,
      fault_set: set.id,
      due: "2099-01-01T00:00:00Z",
      reveal: "answer",
      attempts: 3,
      plan: { duration_s: 12 },
    }));
    browser = await launchBrowser();
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
    await platform?.stop();
    data?.remove();
  });

  function person(hint, more = {}) {
    platform.people.set(hint, {
      sub: `sub-${hint}`,
      name: `${hint} of Moodle`,
      login: hint,
      exercise: exercise.exercise_code,
      item: "e1",
      ...more,
    });
    return hint;
  }
  /** The first half of a launch: what the platform is asked, and the browser's cookie. */
  async function begin(hint) {
    const answer = await fetch(`${platform_login()}?${platform.beginning(hint)}`, {
      redirect: "manual",
    });
    assert.equal(answer.status, 303, await answer.text());
    const to = new URL(answer.headers.get("location"));
    const set = answer.headers.get("set-cookie");
    assert.match(set, /SameSite=None; Partitioned/);
    return {
      state: to.searchParams.get("state"),
      nonce: to.searchParams.get("nonce"),
      cookie: set.split(";")[0],
    };
  }
  const platform_login = () => `${server.url}/api/v1/lti/login`;
  /** The second half, as the browser posts the platform's form. */
  async function finish({ state, cookie }, token, dest = "document") {
    const answer = await fetch(`${server.url}/api/v1/lti/launch`, {
      method: "POST",
      redirect: "manual",
      headers: {
        Cookie: cookie,
        Origin: platform.url,
        "Sec-Fetch-Dest": dest,
        "Content-Type": "application/x-www-form-urlencoded",
      },
      body: new URLSearchParams({ id_token: token, state }),
    });
    const cookies = answer.headers.getSetCookie();
    const session = cookies.map((each) => each.split(";")[0]).find((each) => /session/i.test(each));
    return { status: answer.status, text: await answer.text(), cookies, session, answer };
  }
  async function launch(hint, more = {}, how = {}) {
    const begun = await begin(hint);
    const token = await platform.sign(platform.claimsOf(hint, begun.nonce, more), how);
    return finish(begun, token);
  }
  /** The caller of REST that a launch has signed in. */
  async function signedIn(hint, more) {
    const { status, text, session } = await launch(hint, more);
    assert.equal(status, 303, text);
    const me = await fetch(`${server.url}/api/v1/auth/me`, { headers: { Cookie: session } });
    const json = await me.json();
    return { login: json.login, role: json.role, cookie: session, csrf: json.csrf_token };
  }
  /** One attempt, answered with this value. */
  async function attempt(who, value, of = exercise) {
    const { json: trial } = await world.call(who, "POST", `/assignments/${of.id}/trials`, {});
    await until(
      async () => (await world.call(who, "GET", `/trials/${trial.id}`)).json.state,
      (state) => state === "open",
    );
    const { json } = await world.call(who, "POST", `/trials/${trial.id}/answer`, {
      component: "R9",
      value,
      unit: "ohm",
      confidence: 0.5,
    });
    return json;
  }
  const scoresOf = (hint) => platform.scores.filter((each) => each.userId === `sub-${hint}`);

  story("a student comes by a link, and the grade goes back once", async () => {
    const mila = await signedIn(person("mila"));
    assert.equal(mila.role, "student");
    const { json: tasks } = await world.call(mila, "GET", "/assignments");
    assert.deepEqual(
      tasks.items.map((each) => [each.name, each.exercise_code]),
      [["Exercise 1", null]],
    );
    const { points } = await attempt(mila, 22000);
    await until(
      async () => scoresOf("mila"),
      (scores) => scores.length === 1,
    );
    const [score] = scoresOf("mila");
    assert.equal(score.scoreGiven, points);
    assert.equal(score.scoreMaximum, 100);
    assert.equal(score.item, "e1");

    // A second launch signs in to the same account; the same grade is told again, not another.
    const again = await signedIn("mila");
    assert.equal(again.login, mila.login);
    await until(
      async () => (await sent()).every((each) => each.state === "delivered"),
      (all) => all,
    );
    assert.ok(scoresOf("mila").every((each) => each.scoreGiven === points));

    // A teacher's points go there too.
    const { json: trials } = await world.call(teacher, "GET", `/assignments/${exercise.id}/trials`);
    await world.call(teacher, "PUT", `/trials/${trials.items[0].id}/points`, {
      points: 77,
      reason: "x",
    });
    await until(
      async () => scoresOf("mila").at(-1).scoreGiven,
      (given) => given === 77,
    );
  });

  async function sent() {
    return (await world.call(world.admin, "GET", `/lti/platforms/${registered.id}/grades`)).json
      .items;
  }

  story("a platform that is away gets its grades when it is back", async () => {
    const ana = await signedIn(person("ana"));
    platform.goAway();
    await attempt(ana, 22000);
    await until(sent, (all) => all.some((each) => each.login === "ana" && each.attempts > 1));
    assert.equal((await sent()).find((each) => each.login === "ana").state, "waiting");
    platform.goAway(0);
    await until(
      async () => scoresOf("ana").length,
      (count) => count === 1,
    );
    // A token that has ended is asked for anew.
    platform.forgetTokens();
    await signedIn("ana");
    await until(
      async () => scoresOf("ana").length,
      (count) => count === 2,
    );
  });

  story("attacks on a launch are refused", async () => {
    person("eve");
    const wrong = async (more, how) => {
      const { status, session } = await launch("eve", more, how);
      assert.equal(session, undefined);
      return status;
    };
    const past = Math.floor(Date.now() / 1000) - 3600;
    assert.equal(await wrong({ aud: "somebody else" }), 403);
    assert.equal(await wrong({ iss: "https://evil.example" }), 403);
    assert.equal(await wrong({ nonce: "of another" }), 403);
    assert.equal(await wrong({ exp: past + 300, iat: past }), 403);
    assert.equal(
      await wrong({ iat: past + 7200, exp: past + 7500 }),
      403,
      "a clock that is an hour ahead",
    );
    assert.equal(await wrong({ sub: "" }), 403);
    assert.equal(await wrong({ [`${LTI}version`]: "1.1" }), 403);
    assert.equal(await wrong({ [`${LTI}message_type`]: "LtiSubmissionReviewRequest" }), 403);
    assert.equal(await wrong({ [`${LTI}deployment_id`]: undefined }), 403);
    assert.equal(
      await wrong({ [`${LTI}custom`]: { exercise: `${exercise.id}-AAAAAAAAAAAAAAAAAAAAAA` } }),
      403,
    );
    assert.equal(await wrong({ [`${LTI}roles`]: [`${MEMBER}Observer`] }), 403);

    const begun = await begin("eve");
    const claims = platform.claimsOf("eve", begun.nonce);
    const good = await platform.sign(claims);
    const [header, payload, signature] = good.split(".");
    const none = Buffer.from('{"alg":"none"}').toString("base64url");
    for (const token of [
      `${none}.${payload}.`,
      `${header}.${payload}.${signature.slice(0, -4)}AAAA`,
      `${header}.${Buffer.from(JSON.stringify({ ...claims, sub: "admin" })).toString("base64url")}.${signature}`,
      "",
    ]) {
      assert.equal((await finish(begun, token)).status, 403, token.slice(0, 20));
    }
    assert.equal((await finish({ ...begun, cookie: "" }, good)).status, 403, "another browser");
    assert.equal((await finish({ ...begun, state: "x" }, good)).status, 403);
    const unknown = await fetch(`${platform_login()}?iss=https://other.example&login_hint=x`, {
      redirect: "manual",
    });
    assert.equal(unknown.status, 403);
    assert.match(await unknown.text(), /not registered/);

    assert.equal((await finish(begun, good)).status, 303);
    assert.equal((await finish(begun, good)).status, 403, "a replay");
    const { json: users } = await world.call(world.admin, "GET", "/users?limit=100");
    assert.deepEqual(
      users.items.map((each) => each.login).filter((login) => login === "eve"),
      ["eve"],
    );
  });

  story("keys change, and logins that are taken are told apart", async () => {
    person("teacher", { sub: "another-teacher", item: undefined });
    const other = await signedIn("teacher");
    assert.match(other.login, /^lti\d+-/, "nobody gets an account by its login");
    assert.equal(other.role, "student");

    // Who makes a link writes its custom parameters; a learner's part may be called as a role.
    person("ned", { login: undefined });
    const named = await signedIn("ned", {
      email: "kim@example.org",
      [`${LTI}custom`]: { exercise: exercise.exercise_code, login: "kim" },
      [`${LTI}roles`]: ["http://purl.imsglobal.org/vocab/lis/v2/membership/Learner#Instructor"],
    });
    assert.match(named.login, /^lti\d+-/);
    assert.equal(named.role, "student");

    person("kim");
    assert.equal(
      (await launch("kim", {}, { key: "k2" })).status,
      303,
      "its next key, published already",
    );
    await platform.newKey("k3");
    platform.hideKey("k3");
    assert.equal(
      (await launch("kim", {}, { key: "k3" })).status,
      403,
      "a key that it does not publish",
    );
  });

  story("a teacher connects an account and chooses the exercise on the platform", async () => {
    person("prof", { role: "Instructor", exercise: undefined, item: undefined });
    const refused = await launch("prof");
    assert.equal(refused.status, 403);
    const [ticket] = /\/api\/v1\/lti\/window\?ticket=[\w-]+/.exec(refused.text);
    const click = (cookie, site = "same-origin") =>
      fetch(server.url + ticket, {
        redirect: "manual",
        headers: { Cookie: cookie, "Sec-Fetch-Site": site },
      });
    assert.equal((await click("")).status, 403, "nobody is signed in");
    assert.equal(
      (await click(world.admin.cookie)).status,
      403,
      "an admin is nobody's of a platform",
    );
    assert.equal((await click(teacher.cookie, "cross-site")).status, 403);
    const connected = await click(teacher.cookie);
    assert.equal(connected.headers.get("location"), "/teach");
    assert.equal((await signedIn("prof")).login, "teacher");
    const { json: known } = await world.call(teacher, "GET", "/auth/identities");
    assert.deepEqual(
      known.items.map((each) => [each.provider, each.label]),
      [[`lti:${registered.id}`, "Moodle of the faculty"]],
    );

    const DEEP = "https://purl.imsglobal.org/spec/lti-dl/claim/";
    const asked = {
      [`${LTI}message_type`]: "LtiDeepLinkingRequest",
      [`${DEEP}deep_linking_settings`]: {
        deep_link_return_url: `${platform.url}/choose?"><script>`,
        accept_types: ["ltiResourceLink"],
        data: "csrf&of the platform",
      },
    };
    assert.equal((await launch("prof", asked)).status, 403, "an address that is none");
    asked[`${DEEP}deep_linking_settings`].deep_link_return_url = `${platform.url}/choose?a=1&b=2`;
    assert.equal((await launch("mila", asked)).status, 403, "a student chooses nothing");
    const offered = await launch("prof", asked);
    assert.equal(offered.status, 200, offered.text);
    assert.match(offered.text, /action="http:\/\/localhost:\d+\/choose\?a=1&amp;b=2"/);
    assert.match(offered.text, /<button>Exercise 1<\/button>/);
    const [, jwt] = /name="JWT" value="([\w.-]+)"/.exec(offered.text);
    const chosen = await platform.verify(jwt);
    assert.equal(chosen[`${LTI}message_type`], "LtiDeepLinkingResponse");
    assert.equal(chosen[`${LTI}deployment_id`], "1");
    assert.equal(chosen[`${DEEP}data`], "csrf&of the platform");
    const [item] = chosen[`${DEEP}content_items`];
    assert.equal(item.type, "ltiResourceLink");
    assert.equal(item.custom.exercise, exercise.exercise_code);
    assert.equal(item.lineItem.scoreMaximum, 100);
  });

  story("in a frame of another site the lab opens in a window of its own", async () => {
    person("lea");
    const context = await browser.newContext();
    const course = await context.newPage();
    await course.goto(`${platform.url}/course?in=frame&hint=lea`);
    const link = course.frameLocator("iframe").getByRole("link", { name: "Open the laboratory" });
    const [lab] = await Promise.all([context.waitForEvent("page"), link.click()]);
    await lab.getByText("Exercise 1").waitFor();
    await lab.getByRole("link", { name: "lea of Moodle" }).waitFor();
    const [again] = await Promise.all([context.waitForEvent("page"), link.click()]);
    await again.getByText("This link has been used.").waitFor();
    await context.close();

    const other = await browser.newContext();
    const page = await other.newPage();
    await page.goto(`${platform.url}/course?in=window&hint=lea`);
    await page.getByRole("link", { name: "Exercise" }).click();
    await page.getByText("Exercise 1").waitFor();
    await other.close();
  });

  story("an admin registers a platform, tests it and sees what was sent", async () => {
    const { page, close } = await pageOf(browser, server, world.admin, "/admin", {
      allow: /status of 400/,
    });
    const card = page.getByRole("region", { name: "Learning platforms" });
    await card.getByText("Moodle of the faculty").waitFor();
    await card.getByRole("button", { name: "Test it, Moodle of the faculty" }).click();
    await card.getByText(/publishes \d keys and gives a token for grades/).waitFor();
    await card.getByRole("button", { name: "Grades sent, Moodle of the faculty" }).click();
    await card
      .getByRole("row", { name: /mila.*sent/ })
      .first()
      .waitFor();
    await card.getByText("Register a platform by its values").click();
    assert.deepEqual(await axe(page), []);
    await card.getByLabel("Title").fill("Canvas");
    await card.getByLabel("Issuer").fill("https://canvas.example.org");
    await card.getByLabel("Client ID").fill("10000000000001");
    await card.getByLabel("Address to ask for a launch").fill("ftp://canvas.example.org");
    await card.getByLabel("Address for tokens").fill("https://canvas.example.org/token");
    await card.getByLabel("Address of its keys").fill("https://canvas.example.org/keys");
    await card.getByRole("button", { name: "Register it" }).click();
    await card.getByText(/An address of a platform is https/).waitFor();
    await card.getByLabel("Address to ask for a launch").fill("https://canvas.example.org/auth");
    await card.getByRole("button", { name: "Register it" }).click();
    await card.getByText("Canvas", { exact: true }).waitFor();
    await card.getByRole("button", { name: "Edit, Canvas" }).click();
    await card.getByText(`${server.url}/api/v1/lti/launch`).waitFor();
    assert.equal(await card.getByLabel("Client ID").inputValue(), "10000000000001");
    await card.getByLabel("Title").fill("Canvas of the town");
    await card.getByLabel("Unused accounts of class lists").check();
    await card.getByRole("button", { name: "Save" }).click();
    await card.getByText("Canvas of the town", { exact: true }).waitFor();
    await card.getByRole("button", { name: "Remove, Canvas of the town" }).click();
    await confirmIn(page);
    await card.getByText("Canvas of the town", { exact: true }).waitFor({ state: "detached" });
    await close();
  });

  story("a platform registers itself, and its class comes in", async () => {
    const other = await startPlatform({ host: "localhost", clientId: "not yet" });
    const listed = async () => (await world.call(world.admin, "GET", "/lti/platforms")).json.items;
    const { page, close } = await pageOf(browser, server, world.admin, "/admin");
    const card = page.getByRole("region", { name: "Learning platforms" });
    await card.getByRole("button", { name: "Address to register by", exact: true }).click();
    const address = await card.getByLabel("Address to register by", { exact: true }).textContent();
    await close();
    const invite = async () =>
      (await world.call(world.admin, "POST", "/lti/invitations", {})).json.url;
    const open = async (tool, of = other) => {
      const answer = await fetch(of.registering(tool));
      return `${answer.status} ${await answer.text()}`;
    };

    // What is no registration uses the address up, or leaves it, and registers nothing.
    assert.match(await open(`${server.url}/api/v1/lti/register/${"x".repeat(300)}`), /^403 .*hour/);
    assert.match(await (await fetch(address)).text(), /may be asked/);
    other.issuer = "https://moodle.example.org";
    assert.match(await open(address), /^403 .*lies at another host/);
    delete other.issuer;
    other.goAway();
    assert.match(await open(address), /^403 .*503/);
    other.goAway(0);
    const stale = other.registering(await invite()).replace(/registration-\d+/, "of another");
    assert.match(await (await fetch(stale)).text(), /could not be registered.*invalid_token/);
    assert.equal((await listed()).length, 1);

    const context = await browser.newContext();
    const tools = await context.newPage();
    await tools.goto(`${other.url}/tools?url=${encodeURIComponent(address)}`);
    await tools.frameLocator("iframe").getByText("The laboratory is registered here.").waitFor();
    await until(
      () => tools.title(),
      (title) => title === "registered",
    );
    await context.close();
    assert.match(await open(address), /^403 .*has been used/);
    const [, made] = await listed();
    assert.equal(made.label, "moodle localhost");
    assert.equal(made.issuer, other.url);
    assert.equal(made.client_id, "registered-by-itself");
    assert.equal(made.deployment, "1");
    const { items: told } = (await world.call(world.admin, "GET", "/audit?limit=20")).json;
    assert.ok(
      told.some(
        (each) =>
          each.verb === "create_platform" &&
          each.actor_login === "admin" &&
          each.detail === `moodle localhost ${other.url}`,
      ),
    );
    const values = ({ id: _, created_at: __, ...rest }) => rest;
    const changed = { ...values(made), label: "Moodle of the town", makes_teachers: true };
    const { json: kept } = await world.call(
      world.admin,
      "PUT",
      `/lti/platforms/${made.id}`,
      changed,
    );
    assert.deepEqual(kept, { ...made, ...changed });
    const again = await (await browser.newContext()).newPage();
    await again.goto(`${other.url}/tools?url=${encodeURIComponent(address)}`);
    await again.frameLocator("iframe").getByText("This address has been used").waitFor();
    await again.context().close();

    const first = platform;
    platform = other;
    try {
      const { json: course } = await world.call(teacher, "POST", "/courses", { name: "Town" });
      const { json: given } = await world.call(teacher, "POST", "/assignments", {
        ...LATE,
        name: "Exercise of the town",
        course: course.id,
        fault_set: exercise.fault_set,
        due: "2099-01-01T00:00:00Z",
      });
      const roster = `/courses/${course.id}/rosters`;
      await assert.rejects(world.call(teacher, "POST", roster, {}), /404.*no_roster/);
      const guide = person("guide", { role: "Instructor", exercise: given.exercise_code });
      assert.equal((await signedIn(guide)).role, "instructor");
      for (let i = 0; i < 120; i += 1) person(`town${i}`, i % 2 ? { name: undefined } : {});
      person("gone", { status: "Inactive" });
      // Who has an account here is asked.
      const asked = await signedIn(person("town9", { exercise: undefined }));
      person("watcher", { role: "Mentor" });
      const { json: leading } = await world.call(teacher, "GET", roster);
      assert.deepEqual(leading.items, [{ platform: made.id, label: "Moodle of the town" }]);
      const student = await signedIn(person("town7", { exercise: given.exercise_code }));
      await assert.rejects(world.call(student, "POST", roster, {}), /403/);

      other.continueAt("https://evil.example/next");
      await assert.rejects(world.call(teacher, "POST", roster, {}), /503.*does not end/);
      other.continueAt("");

      const teaches = await pageOf(browser, server, teacher, "/teach");
      await teaches.page.getByRole("button", { name: "Add members, Town" }).click();
      const take = teaches.page.getByRole("button", {
        name: "Take the students from Moodle of the town",
      });
      await take.click();
      await confirmIn(teaches.page);
      await teaches.page.getByText("118 students joined. Here before: 1. Invited: 1.").waitFor();
      await teaches.page.getByText("town0 of Moodle").waitFor();
      assert.deepEqual(await axe(teaches.page), []);
      await teaches.close();
      const { json: again } = await world.call(teacher, "POST", roster, {});
      assert.deepEqual(again, { joined: 0, invited: 1, attended: 119, refused: 0 });
      const { json: invitations } = await world.call(asked, "GET", "/invitations");
      assert.deepEqual(
        invitations.items.map((each) => each.course_name),
        ["Town"],
      );
      // Whoever came in by the list is who follows the link.
      assert.equal((await signedIn("town0")).login, "town0");
      const elsewhere = { ...changed, issuer: "https://moodle.example.org" };
      await assert.rejects(
        world.call(world.admin, "PUT", `/lti/platforms/${made.id}`, elsewhere),
        /409.*platform_issuer_stays/,
      );
    } finally {
      platform = first;
      await other.stop();
    }
  });

  story("the grades of 250 students arrive though the server is killed twice", async () => {
    const hints = Array.from({ length: 250 }, (_, i) => person(`s${i}`));
    const people = new Map();
    const each = async (width, work) => {
      const left = [...hints];
      const worker = async () => {
        for (let hint = left.shift(); hint; hint = left.shift()) await work(hint);
      };
      await Promise.all(Array.from({ length: width }, worker));
    };
    const killed = async () => {
      const { url } = server;
      await server.stop("SIGKILL");
      server = await startServer(started({ listen: new URL(url).host }));
    };
    await each(8, async (hint) => people.set(hint, await signedIn(hint)));
    platform.goAway();
    // More want to begin than there are simulators.
    await each(8, async (hint) => {
      for (;;) {
        const done = await attempt(people.get(hint), 22000).catch((error) => error);
        if (done.points !== undefined) return;
        assert.match(String(done), /409|429|503/);
      }
    });
    await killed();
    platform.goAway(0);
    // What is due is told though nobody looks at it here.
    const { json: late } = await world.call(teacher, "POST", "/assignments", {
      ...LATE,
      course: exercise.course,
      fault_set: exercise.fault_set,
      due: "2099-01-01T00:00:00Z",
    });
    const eli = await signedIn(person("eli", { exercise: late.exercise_code, item: "late" }));
    await attempt(eli, 22000, late);
    assert.equal(scoresOf("eli").length, 0);
    const arrived = () => hints.filter((hint) => scoresOf(hint).length > 0).length;
    await until(
      async () => arrived() > 50,
      (some) => some,
    );
    const due = { due: new Date().toISOString() };
    const seen = { "If-Match": `"${late.version}"` };
    await world.call(teacher, "PATCH", `/assignments/${late.id}`, due, undefined, seen);
    await killed();
    await until(
      async () => scoresOf("eli").length,
      (count) => count === 1,
    );
    await until(
      async () => arrived(),
      (count) => count === hints.length,
    );
    const again =
      platform.scores.filter((score) => /^sub-s\d+$/.test(score.userId)).length - hints.length;
    assert.ok(again <= 2, `${again} were sent twice`); // what was on its way when the server was killed
  });
});
