import type { AuditEntry, Span, User } from "../contract/lab_types";
import type { Page, Schemas } from "../contract/types";
import { get, send } from "./client";

export type Alarm = Schemas["Alarm"];
export type CheckStep = Schemas["CheckStep"];
export type RigCheck = Schemas["RigCheck"];
export type RigDay = Schemas["RigDay"];
export type RelayCycles = Schemas["RelayCycles"];
export type RigHistory = Schemas["RigHistory"];
export type Waiting = Schemas["WaitingPerson"];
export type Webhook = Schemas["Webhook"];
export type MessageKind = Schemas["MessageKind"];
export type OutageEffect = Schemas["OutageEffect"];

/** What a search asks for; an empty member restricts nothing. */
export interface UserFilter {
  q?: string;
  role?: string;
  course?: string;
}
export interface AuditFilter {
  q?: string;
  /** Verbs of the log, separated by commas. */
  verbs?: string;
  who?: string;
  from?: string;
  to?: string;
}

const at = (id: string | number) => encodeURIComponent(String(id));
function page<T>(path: string, filter: object = {}, cursor?: string): Promise<Page<T>> {
  const query = new URLSearchParams({ limit: "50" });
  for (const [name, value] of Object.entries({ ...filter, cursor })) {
    if (value) query.set(name, String(value));
  }
  return get<Page<T>>(`${path}?${query}`);
}

/** What operators and administrators look at. */
export const operate = {
  alarms: (state: "open" | "all", cursor?: string) => page<Alarm>("/alarms", { state }, cursor),
  acknowledge: (alarm: number) => send<Alarm>("POST", `/alarms/${at(alarm)}/acknowledge`, {}),
  queue: (cursor?: string) => page<Waiting>("/queue", {}, cursor),
  /** @param until  end of the last of the 30 days, ISO 8601 */
  history: (rig: string, until: string) =>
    get<RigHistory>(`/rigs/${at(rig)}/history?until=${at(until)}`),
  relayReplaced: (rig: string, line: number) =>
    send<unknown>("POST", `/rigs/${at(rig)}/relays/${line}/replaced`, {}),
  outageEffect: (rig: string, span: Span) =>
    get<OutageEffect>(
      `/rigs/${at(rig)}/outages/preview?start=${at(span.start)}&end=${at(span.end)}`,
    ),
  users: (filter: UserFilter, cursor?: string) => page<User>("/users", filter, cursor),
  webhooks: async () => (await get<Page<Webhook>>("/webhooks")).items,
  /** The answer has the secret, which is shown only once. */
  addWebhook: (url: string, kinds: MessageKind[]) =>
    send<Schemas["NewWebhook"]>("POST", "/webhooks", { url, kinds }),
  testWebhook: (hook: number) =>
    send<Schemas["WebhookTest"]>("POST", `/webhooks/${at(hook)}/test`, {}),
  removeWebhook: (hook: number) => send<unknown>("DELETE", `/webhooks/${at(hook)}`),
  audit: (filter: AuditFilter, cursor?: string) => page<AuditEntry>("/audit", filter, cursor),
};
