import type { Component } from "../api/types";
import { sameValue } from "./components";

/** One fault of the paper: what its Tables 3-10 print, and what it identified (Tables 11-12). */
export interface PublishedFault {
  component: Component;
  value: number;
  swa: [number, number, number]; // b0d, b1d, a1d
  sia: [number, number, number]; // b0, b1, a1
  identified: number;
}

type Row = [Component, number, [number, number, number], [number, number, number], number];

// The R9 rows of Table 7 for 33 and 100 kohm are exchanged in print; here they stand as printed.
const ROWS: Row[] = [
  ["R1", 10, [1.421, -0.82, -0.738], [2.306, 0.0546, 0.038], 9.8],
  ["R1", 56, [0.472, -0.279, -0.896], [1.85, 0.047, 0.15], 49],
  ["R1", 100, [0.29, -0.18, -0.925], [1.495, 0.0352, 0.126], 79],
  ["R9", 33e3, [1.488, -0.5, -0.373], [1.331, 0.0245, 0.0199], 17e3],
  ["R9", 56e3, [1.337, -0.412, -0.35], [1.425, 0.03, 0.0221], 18.2e3],
  ["R9", 100e3, [1.258, -0.359, -0.316], [1.575, 0.032, 0.022], 19e3],
  ["R12", 2e3, [0.757, -0.368, -0.514], [0.8, 0.0175, 0.023], 2e3],
  ["R12", 3.3e3, [1, -0.458, -0.492], [1.059, 0.0228, 0.0228], 3.3e3],
  ["R12", 5.6e3, [1.434, -0.784, -0.572], [1.521, 0.0325, 0.022], 5.6e3],
  ["C8", 1e-6, [1.148, -0.013, -0.526], [2.39, 0.024, 0.0209], 9.7e-7],
  ["C8", 1e-5, [0.312, -0.142, -0.929], [2.387, 0.044, 0.141], 9.7e-6],
  ["C8", 4.7e-5, [0.21, -0.168, -0.982], [2.386, 0.1142, 0.56], 4.6e-5],
  ["Ra", 0.741, [1.9, 0.356, -0.06], [2.393, 0.02, 0.011], 0.62],
  ["Ra", 74.1, [2.369, -2.227, -0.94], [2.395, 0.143, 0.06], 64.4],
  ["J", 1.43e-4, [2.12, -2.13, -1], [2.392, 3.794, 1.824], 1.43e-4],
  ["J", 1.43e-8, [2.34, -0.192, -0.083], [2.394, 0.018, 0.008], 1.45e-8],
  ["B", 1.8e-4, [2.162, -0.34, -0.172], [2.2, 0.026, 0.012], 5.7e-5],
  ["B", 1.8e-5, [2.177, -1.062, -0.524], [2.346, 0.0462, 0.0213], 1.53e-5],
];

export const PUBLISHED: PublishedFault[] = ROWS.map(([component, value, swa, sia, identified]) => ({
  component,
  value,
  swa,
  sia,
  identified,
}));

/** The paper's row for this fault, if it made that experiment. */
export function publishedFor(component: Component, value: number): PublishedFault | null {
  return (
    PUBLISHED.find((row) => row.component === component && sameValue(row.value, value)) ?? null
  );
}
