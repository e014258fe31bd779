import type { Plugin } from "vite";
export function refusals(): Plugin;
