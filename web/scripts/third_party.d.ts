import type { Plugin } from "vite";

export function listedPackages(text: string): Map<string, string>;
export function licenceFaults(bundled: Map<string, string>, listed: Map<string, string>): string[];
export function thirdParty(): Plugin;
