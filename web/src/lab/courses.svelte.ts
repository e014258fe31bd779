import { lab } from "../api/lab_client";
import type { Course } from "../contract/lab_types";

/** The user's courses, the same in every part of the page. */
class Courses {
  list = $state.raw<Course[]>([]);

  async load(): Promise<void> {
    this.list = await lab.courses();
  }
}

export const courses = new Courses();
