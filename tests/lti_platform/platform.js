// A learning platform, assembled from `jose` (npm): none of this project's code signs or checks anything here. It does what
// Moodle and Canvas do, with their traps: a token that is answered as text/html, a line item that ends in a query, a score
// whose Content-Type may have no charset, 409 for a score that is not newer, 400 for whoever cannot be graded.
import { createServer } from "node:http";
import { createRequire } from "node:module";

// The packages of the sign-in provider's tests.
const require = createRequire(new URL("../oidc_provider/package.json", import.meta.url));
const jose = await import(require.resolve("jose"));

const LTI = "https://purl.imsglobal.org/spec/lti/claim/";
const AGS = "https://purl.imsglobal.org/spec/lti-ags/";
export const MEMBER = "http://purl.imsglobal.org/vocab/lis/v2/membership#";

const TOOL = "https://purl.imsglobal.org/spec/lti-tool-configuration";
const ROSTER = "https://purl.imsglobal.org/spec/lti-nrps/";

export async function startPlatform({ clientId = "lab-client", host = "127.0.0.1" } = {}) {
  const keys = new Map();
  async function newKey(kid) {
    const { publicKey, privateKey } = await jose.generateKeyPair("RS256", { extractable: true });
    keys.set(kid, {
      privateKey,
      jwk: { ...(await jose.exportJWK(publicKey)), kid, alg: "RS256", use: "sig" },
    });
    return kid;
  }
  const kid = await newKey("k1");
  const hidden = new Set();
  let tool; // its addresses
  let away = 0; // the status that it answers then
  let tokens = 0;
  const given = new Map(); // access token -> scope
  const registrations = new Set(); // tokens of registrations that have begun
  let elsewhere = ""; // where its list of people says that it goes on
  const scores = []; // taken, in order
  const people = new Map(); // by login_hint
  const seen = new Set(); // jti of assertions

  async function body(request) {
    let text = "";
    for await (const part of request) text += part;
    return text;
  }
  function answer(response, status, value, type = "application/json") {
    response.writeHead(status, { "Content-Type": type });
    response.end(typeof value === "string" ? value : JSON.stringify(value));
  }

  /** The claims of a launch of this person. */
  function claimsOf(hint, nonce, more = {}) {
    const now = Math.floor(Date.now() / 1000);
    const { sub, name, login, role = "Learner", exercise, item } = people.get(hint);
    return {
      iss: platform.url,
      aud: clientId,
      sub,
      iat: now,
      exp: now + 300,
      nonce,
      name,
      [`${LTI}version`]: "1.3.0",
      [`${LTI}message_type`]: "LtiResourceLinkRequest",
      [`${LTI}deployment_id`]: "1",
      [`${LTI}target_link_uri`]: tool?.launch_url,
      [`${LTI}resource_link`]: { id: "7", title: "Exercise" },
      [`${LTI}context`]: { id: "42", title: "Drives" },
      [`${LTI}roles`]: [`${MEMBER}${role}`],
      [`${LTI}ext`]: { lms: "moodle-2", user_username: login },
      [`${LTI}custom`]: exercise ? { exercise } : {},
      [`${ROSTER}claim/namesroleservice`]: {
        context_memberships_url: `${platform.url}/memberships?course=42`,
        service_versions: ["2.0"],
      },
      ...(item
        ? {
            [`${AGS}claim/endpoint`]: {
              scope: [`${AGS}scope/score`],
              lineitem: `${platform.url}/lineitems/${item}/lineitem?type_id=7`,
            },
          }
        : {}),
      ...more,
    };
  }
  async function sign(claims, { key = kid, alg = "RS256" } = {}) {
    return new jose.SignJWT(claims)
      .setProtectedHeader({ alg, kid: key, typ: "JWT" })
      .sign(keys.get(key).privateKey);
  }

  async function giveToken(request, response) {
    const form = new URLSearchParams(await body(request));
    try {
      const { payload } = await jose.jwtVerify(
        form.get("client_assertion"),
        jose.createRemoteJWKSet(new URL(tool.keys_url)),
        {
          issuer: clientId,
          subject: clientId,
          audience: `${platform.url}/token`,
          maxTokenAge: "5 min",
        },
      );
      if (seen.has(payload.jti)) throw new Error("used");
      seen.add(payload.jti);
    } catch (error) {
      return answer(response, 400, { error: "invalid_client", error_description: String(error) });
    }
    if (form.get("grant_type") !== "client_credentials") {
      return answer(response, 400, { error: "unsupported_grant_type" });
    }
    tokens += 1;
    given.set(`token-${tokens}`, form.get("scope"));
    return answer(
      response,
      200,
      {
        access_token: `token-${tokens}`,
        token_type: "Bearer",
        expires_in: 3600.5,
        scope: form.get("scope"),
      },
      "text/html; charset=utf-8",
    );
  }
  const grants = (request, scope) =>
    given.get(request.headers.authorization?.replace("Bearer ", "")) === scope;
  /** Page by page; Moodle's Link has typographic quotes. */
  function tellPeople(request, response, url) {
    if (!grants(request, `${ROSTER}scope/contextmembership.readonly`)) {
      return answer(response, 401, {});
    }
    const from = Number(url.searchParams.get("from") ?? 0);
    const limit = Math.min(Number(url.searchParams.get("limit") ?? 50), 50);
    const all = [...people.values()];
    if (from + limit < all.length || elsewhere) {
      const next = elsewhere || `${platform.url}/memberships?course=42&from=${from + limit}`;
      response.setHeader(
        "Link",
        Buffer.from(
          `<${platform.url}/x>; rel="differences", <${next}>; rel=\u201cnext\u201d`,
        ).toString("latin1"),
      );
    }
    return answer(
      response,
      200,
      {
        id: url.href,
        context: { id: "42", title: "Drives" },
        members: all.slice(from, from + limit).map(({ sub, name, login, role, status }) => ({
          user_id: sub,
          name,
          ext_user_username: login,
          roles: [role ?? "Learner"],
          ...(status ? { status } : {}),
        })),
      },
      "application/vnd.ims.lti-nrps.v2.membershipcontainer+json",
    );
  }
  /** As Moodle's registration.php: a token once, and what a tool must say. */
  async function register(request, response) {
    const token = request.headers.authorization?.replace("Bearer ", "");
    if (!registrations.delete(token)) return answer(response, 401, { error: "invalid_token" });
    const asked = JSON.parse(await body(request));
    const right =
      asked.application_type === "web" &&
      asked.response_types.includes("id_token") &&
      ["implicit", "client_credentials"].every((each) => asked.grant_types.includes(each)) &&
      asked.token_endpoint_auth_method === "private_key_jwt" &&
      asked.redirect_uris.includes(asked[TOOL].target_link_uri) &&
      asked[TOOL].domain === new URL(asked.initiate_login_uri).host &&
      asked[TOOL].messages.some((each) => each.type === "LtiDeepLinkingRequest") &&
      asked.scope === `${AGS}scope/score ${ROSTER}scope/contextmembership.readonly`;
    if (!right) return answer(response, 400, { error: "invalid_client_metadata" });
    tool = {
      login_url: asked.initiate_login_uri,
      launch_url: asked.redirect_uris[0],
      keys_url: asked.jwks_uri,
    };
    clientId = "registered-by-itself";
    return answer(response, 200, {
      ...asked,
      client_id: clientId,
      [TOOL]: { ...asked[TOOL], deployment_id: 1 },
    });
  }
  async function takeScore(request, response, item) {
    if (!grants(request, `${AGS}scope/score`)) return answer(response, 401, {});
    if (request.headers["content-type"] !== "application/vnd.ims.lis.v1.score+json") {
      return answer(response, 400, { error: "content type" });
    }
    const score = JSON.parse(await body(request));
    const before = scores
      .filter((each) => each.item === item && each.userId === score.userId)
      .at(-1);
    if (before && Date.parse(score.timestamp) <= Date.parse(before.timestamp)) {
      return answer(response, 409, {});
    }
    if (score.userId === "preview") return answer(response, 400, { error: "not gradable" });
    if (!(score.scoreGiven <= score.scoreMaximum) || score.gradingProgress !== "FullyGraded") {
      return answer(response, 422, {});
    }
    scores.push({ item, ...score });
    return answer(response, 200, {});
  }
  /** What a browser is answered: a form that posts itself. */
  async function askWho(url, response) {
    const query = url.searchParams;
    const right =
      query.get("client_id") === clientId &&
      query.get("redirect_uri") === tool.launch_url &&
      query.get("response_mode") === "form_post" &&
      query.get("lti_message_hint") === '{"cmid":7}';
    if (!right) return answer(response, 400, "the request is wrong", "text/plain");
    const token = await sign(claimsOf(query.get("login_hint"), query.get("nonce")));
    return answer(
      response,
      200,
      `<form method="post" action="${query.get("redirect_uri")}"><input name="id_token" value="${token}">` +
        `<input name="state" value="${query.get("state")}"></form><script>document.forms[0].submit()</script>`,
      "text/html",
    );
  }

  const server = createServer((request, response) => {
    const url = new URL(request.url, platform.url);
    const item = /^\/lineitems\/([^/]+)\/lineitem\/scores$/.exec(url.pathname);
    const work = away
      ? answer(response, away, "away", "text/plain")
      : url.pathname === "/auth"
        ? askWho(url, response)
        : url.pathname === "/token"
          ? giveToken(request, response)
          : url.pathname === "/jwks"
            ? answer(response, 200, {
                keys: [...keys].filter(([name]) => !hidden.has(name)).map(([, each]) => each.jwk),
              })
            : url.pathname === "/course"
              ? answer(response, 200, coursePage(url), "text/html")
              : url.pathname === "/openid-configuration"
                ? answer(response, 200, describe())
                : url.pathname === "/register"
                  ? register(request, response)
                  : url.pathname === "/tools"
                    ? answer(response, 200, toolsPage(url), "text/html")
                    : url.pathname === "/memberships"
                      ? tellPeople(request, response, url)
                      : item && url.searchParams.get("type_id") === "7"
                        ? takeScore(request, response, item[1])
                        : answer(response, 404, {});
    Promise.resolve(work).catch((error) => answer(response, 500, String(error)));
  });
  const describe = () => ({
    issuer: platform.issuer ?? platform.url,
    authorization_endpoint: `${platform.url}/auth`,
    token_endpoint: `${platform.url}/token`,
    jwks_uri: `${platform.url}/jwks`,
    registration_endpoint: `${platform.url}/register`,
    scopes_supported: ["openid", `${AGS}scope/score`, `${ROSTER}scope/contextmembership.readonly`],
    "https://purl.imsglobal.org/spec/lti-platform-configuration": {
      product_family_code: "moodle",
      version: "4.5",
    },
  });
  /** Where an administrator has pasted a tool's address: it is opened in a frame, and says when it is done. */
  function toolsPage(url) {
    return (
      `<h1>Tools</h1><iframe src="${platform.registering(url.searchParams.get("url")).replaceAll("&", "&amp;")}" width="800" height="400"></iframe>` +
      `<script>addEventListener("message", ({ data }) => { if (data.subject === "org.imsglobal.lti.close") document.title = "registered"; })</script>`
    );
  }
  /** A page of a course, with the link in a frame, or in a window of its own. */
  function coursePage(url) {
    const begin =
      `${tool.login_url}?${platform.beginning(url.searchParams.get("hint"))}`.replaceAll(
        "&",
        "&amp;",
      );
    return url.searchParams.get("in") === "frame"
      ? `<h1>Drives</h1><iframe src="${begin}" width="800" height="400"></iframe>`
      : `<h1>Drives</h1><a href="${begin}">Exercise</a>`;
  }

  const platform = {
    url: "",
    scores,
    people,
    claimsOf,
    sign,
    newKey,
    /** It signs with this key, and does not publish it. */
    hideKey: (name) => hidden.add(name),
    goAway(status = 503) {
      away = status;
    },
    meet(addresses) {
      tool = addresses;
    },
    forgetTokens: () => given.clear(),
    /** The next page of its people lies there. */
    continueAt(address) {
      elsewhere = address;
    },
    /** The address of a tool, as it is opened to register it. */
    registering(address) {
      tokens += 1;
      registrations.add(`registration-${tokens}`);
      const query = {
        openid_configuration: `${platform.url}/openid-configuration`,
        registration_token: `registration-${tokens}`,
      };
      return `${address}?${new URLSearchParams(query)}`;
    },
    /** The claims of what the tool hands back. */
    verify: async (token) =>
      (
        await jose.jwtVerify(token, jose.createRemoteJWKSet(new URL(tool.keys_url)), {
          issuer: clientId,
          audience: platform.url,
        })
      ).payload,
    /** As an admin registers it. */
    registration: () => ({
      label: "Moodle of the faculty",
      issuer: platform.url,
      client_id: clientId,
      auth_url: `${platform.url}/auth`,
      token_url: `${platform.url}/token`,
      keys_url: `${platform.url}/jwks`,
    }),
    /** The query with which a link begins. */
    beginning: (hint) =>
      new URLSearchParams({
        iss: platform.url,
        client_id: clientId,
        login_hint: hint,
        lti_message_hint: '{"cmid":7}',
        target_link_uri: tool.launch_url,
      }).toString(),
    async stop() {
      server.closeAllConnections();
      await new Promise((resolve) => server.close(resolve));
    },
  };
  await new Promise((resolve) =>
    server.listen(0, host === "localhost" ? "127.0.0.1" : host, resolve),
  );
  platform.url = `http://${host}:${server.address().port}`;
  return platform;
}
