import type { Isolability } from "../contract/lab_types";
import type { Schemas } from "../contract/types";
import { get, getAll, send } from "./client";

/** Blind exercises: their pools of faults, trials, answers and grades. */
export type FaultPool = Schemas["FaultPool"];
export type Assignment = Schemas["Assignment"];
export type AssignmentRequest = Schemas["AssignmentRequest"];
export interface AssignmentPreview {
  bench: string;
  pool: FaultPool;
  plan: Schemas["AssignmentPlan"];
}
export type Trial = Schemas["Trial"];
export type Answer = Schemas["Answer"];
export type Rubric = Schemas["Rubric"];
export type Grade = Schemas["Grade"];
export type AssignmentStatistics = Schemas["AssignmentStatistics"];
/** `Trial.truth`, read. */
export interface Truth {
  faults: Schemas["Fault"][];
  seed: number;
}

export const course = {
  assignments: () => getAll<Assignment>("/assignments"),
  assignment: (id: number) => get<Assignment>(`/assignments/${id}`),
  /** Nothing is kept. */
  preview: (request: AssignmentPreview) =>
    send<Isolability>("POST", "/assignments/preview", request),
  assign: (request: AssignmentRequest) => send<Assignment>("POST", "/assignments", request),
  /** Refused when somebody else has changed it since. */
  change: ({ id, version }: Assignment, change: Schemas["AssignmentChange"]) =>
    send<Assignment>("PATCH", `/assignments/${id}`, change, { "If-Match": `"${version}"` }),
  extend: (id: number, account: number, due: string) =>
    send<Assignment>("PUT", `/assignments/${id}/extensions/${account}`, { due }),
  endExtension: (id: number, account: number) =>
    send<Assignment>("DELETE", `/assignments/${id}/extensions/${account}`),
  /** Forms a group, or joins that of a code. */
  enterGroup: (id: number, code: string) =>
    send<unknown>("POST", `/assignments/${id}/group`, code ? { code } : {}),
  leaveGroup: (id: number) => send<unknown>("DELETE", `/assignments/${id}/group`),
  statistics: (id: number) => get<AssignmentStatistics>(`/assignments/${id}/statistics`),
  award: (trial: number, points: number, reason: string) =>
    send<Trial>("PUT", `/trials/${trial}/points`, { points, reason }),
  takeAwardBack: (trial: number) => send<Trial>("DELETE", `/trials/${trial}/points`),
  remove: (id: number) => send<unknown>("DELETE", `/assignments/${id}`),
  gradesAddress: (id: number) => `/api/v1/assignments/${id}/grades.csv`,
  trials: (assignment: number) => getAll<Trial>(`/assignments/${assignment}/trials`),
  begin: (assignment: number, request: Schemas["TrialRequest"]) =>
    send<Trial>("POST", `/assignments/${assignment}/trials`, request),
  trial: (id: number) => get<Trial>(`/trials/${id}`),
  answer: (id: number, answer: Answer) => send<Trial>("POST", `/trials/${id}/answer`, answer),
};
