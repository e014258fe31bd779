import type { Component } from "../api/types";
import { NOMINAL } from "./components";

const R5 = 1e3;
const R10 = 10e3;
const R14 = 1e3;
const R15 = 1e3;
const KE = 25.5e-3;
const KT = 25.5e-3;

export interface Continuous {
  b0: number;
  b1: number;
  a1: number;
}
export interface Discrete {
  b0d: number;
  b1d: number;
  a1d: number;
}

/**
 * The paper's Eq. 4: parameters of Um/Uc = (b1 s + b0)/(a1 s + 1), with one component changed.
 *   k = Re2/Re1, D = B (Ra + R1) + Ke KT, N = B Ra + Ke KT
 */
export function continuousModel(changed: Partial<Record<Component, number>> = {}): Continuous {
  const p = { ...NOMINAL, ...changed };
  const re1 = (p.R9 * R10) / (p.R9 + R10);
  const re2 = p.R12 + R14 + R15;
  const k = re2 / re1;
  const d = p.B * (p.Ra + p.R1) + KE * KT;
  const n = p.B * p.Ra + KE * KT;
  return {
    b0: (k * n) / d,
    b1: (k * (p.J * p.Ra + p.C8 * R5 * n)) / d,
    a1: (p.J * (p.Ra + p.R1) + p.C8 * (R5 + re2) * d) / d,
  };
}

/**
 * What a least squares of um(k) on uc(k), uc(k-1), um(k-1) reads of that model when um is sampled
 * `delta` seconds after the converter's edge (Eq. 9 is delta = 0).
 */
export function discreteModel(c: Continuous, period: number, delta: number): Discrete {
  const e = Math.exp(-period / c.a1);
  const direct = c.b0 - (c.b0 - c.b1 / c.a1) * Math.exp(-delta / c.a1);
  return { b0d: direct, b1d: c.b0 * (1 - e) - direct, a1d: -e };
}
