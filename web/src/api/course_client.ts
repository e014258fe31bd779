import { account } from "../shell/account.svelte";
import { get, send } from "./client";
import type { FaultSet } from "./lab_types";
import type { Page, Schemas } from "./types";

/** Blind exercises: their pools of faults, trials, answers and grades. */
export type FaultPool = Schemas["FaultPool"];
export type Assignment = Schemas["Assignment"];
export type AssignmentRequest = Schemas["AssignmentRequest"];
export type Trial = Schemas["Trial"];
export type Answer = Schemas["Answer"];
export type Grade = Schemas["Grade"];
/** `Trial.truth`, read. */
export interface Truth {
  faults: Schemas["Fault"][];
  seed: number;
}

export const isMine = (trial: Trial) => account.me.owner === `user:${trial.account}`;

const items = async <T>(path: string) => (await get<Page<T>>(`${path}?limit=200`)).items;

export const course = {
  assignments: () => items<Assignment>("/assignments"),
  assignment: (id: number) => get<Assignment>(`/assignments/${id}`),
  makePool: (set: { name: string; course: number; bench: string; pool: FaultPool }) =>
    send<FaultSet>("POST", "/fault-sets", set),
  assign: (request: AssignmentRequest) => send<Assignment>("POST", "/assignments", request),
  remove: (id: number) => send<unknown>("DELETE", `/assignments/${id}`),
  gradesAddress: (id: number) => `/api/v1/assignments/${id}/grades.csv`,
  trials: (assignment: number) => items<Trial>(`/assignments/${assignment}/trials`),
  begin: (assignment: number) => send<Trial>("POST", `/assignments/${assignment}/trials`, {}),
  trial: (id: number) => get<Trial>(`/trials/${id}`),
  answer: (id: number, answer: Answer) => send<Trial>("POST", `/trials/${id}/answer`, answer),
};
