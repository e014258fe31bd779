// A provider as at a university: oidc-provider from npm. Everybody signs in under the name that
// they type, and consents to everything.
import { exportJWK, generateKeyPair } from "jose";
import Provider from "oidc-provider";
import { bodyOf } from "./listener.js";

const people = {
  ann: { name: "Ana Anić", preferred_username: "ann", email: "ann@uns.example" },
  stranger: { name: "Stranger", preferred_username: "stranger", email: "s@elsewhere.example" },
  admin: { name: "Not The Admin", preferred_username: "admin", email: "admin@uns.example" },
};

/** A request handler. `client` is the registration of the server under test. */
export async function realProvider(issuer, client) {
  const { privateKey } = await generateKeyPair("RS256", { extractable: true });
  const provider = new Provider(issuer, {
    clients: [client],
    jwks: { keys: [{ ...(await exportJWK(privateKey)), kid: "real-1", alg: "RS256", use: "sig" }] },
    cookies: { keys: ["a key for a test"] },
    claims: {
      openid: ["sub"],
      profile: ["name", "preferred_username"],
      email: ["email", "email_verified"],
    },
    features: { devInteractions: { enabled: false } },
    interactions: { url: (_context, interaction) => `/interaction/${interaction.uid}` },
    pkce: { required: () => true },
    ttl: {
      AccessToken: 300,
      AuthorizationCode: 60,
      Grant: 300,
      IdToken: 300,
      Interaction: 300,
      Session: 300,
    },
    findAccount: (_context, id) => ({
      accountId: id,
      claims: () => ({ sub: id, email_verified: true, ...people[id.replace("id-of-", "")] }),
    }),
    async loadExistingGrant(context) {
      const { client: asking, session } = context.oidc;
      const grant = new context.oidc.provider.Grant({
        clientId: asking.clientId,
        accountId: session.accountId,
      });
      grant.addOIDCScope("openid profile email");
      await grant.save();
      return grant;
    },
  });
  const answer = provider.callback();
  return async (request, response) => {
    if (!request.url.startsWith("/interaction/")) return answer(request, response);
    if (request.method === "POST") {
      const login = (await bodyOf(request)).get("login");
      const result =
        login === "nobody"
          ? { error: "access_denied", error_description: "<script>alert(1)</script>" }
          : { login: { accountId: `id-of-${login}` } };
      return provider.interactionFinished(request, response, result);
    }
    response.writeHead(200, { "Content-Type": "text/html" });
    return response.end(
      '<!doctype html><title>University</title><form method="post"><label>Name <input name="login"></label><button>Sign in</button></form>',
    );
  };
}
