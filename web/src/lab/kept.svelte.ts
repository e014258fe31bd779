import { getAll } from "../api/client";
import type { Course, FaultSet } from "../contract/types";

/** What there is for the user of one kind, the same in every part of the page. */
class Kept<T> {
  list = $state.raw<T[]>([]);

  constructor(private readonly path: string) {}

  async load(): Promise<void> {
    this.list = await getAll<T>(this.path);
  }
}

export const courses = new Kept<Course>("/courses");
export const faultSets = new Kept<FaultSet>("/fault-sets");
