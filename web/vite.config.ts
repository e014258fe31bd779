/// <reference types="vitest/config" />
import { svelte } from "@sveltejs/vite-plugin-svelte";
import { defineConfig } from "vite";
import { firstTexts } from "./scripts/first_texts.js";
import { refusals } from "./scripts/refusals.js";
import { baseChunk, runChunk } from "./scripts/run_chunk.js";
import { thirdParty } from "./scripts/third_party.js";

const backend = process.env.FAULTLAB_URL ?? "http://127.0.0.1:8080";

export default defineConfig({
  plugins: [refusals(), firstTexts(), svelte(), thirdParty()],
  build: {
    target: "es2022",
    assetsInlineLimit: 0, // the Content-Security-Policy allows no data: URLs
    manifest: true,
    modulePreload: { polyfill: false },
    reportCompressedSize: false,
    rolldownOptions: {
      output: {
        codeSplitting: { groups: [baseChunk(), runChunk()], includeDependenciesRecursively: false },
      },
    },
  },
  server: {
    proxy: {
      // the server compares Origin with Host
      "/api/v1": { target: backend, changeOrigin: false },
      "/healthz": backend,
      "/readyz": backend,
      "/ws": { target: backend, ws: true, changeOrigin: false },
    },
  },
  preview: { strictPort: true },
  resolve: process.env.VITEST ? { conditions: ["browser"] } : {},
  test: {
    include: ["tests/**/*.test.ts"],
    setupFiles: ["tests/support/all_texts.ts"],
    environment: "node",
  },
});
