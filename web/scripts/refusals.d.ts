import type { Plugin } from "vite";
export function refusals(): Plugin;
export const file: string;
