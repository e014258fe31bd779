import type { MethodName } from "../contract/lab_types";
import type { Key } from "../i18n/catalogue";

/** What the page says of each method: its title, and when to use it and where it breaks. */
export const METHODS: Record<MethodName, { title: Key; text: Key }> = {
  ls: { title: "method_title_ls", text: "method_text_ls" },
  rls: { title: "method_title_rls", text: "method_text_rls" },
  "rls-reset": { title: "method_title_rls_reset", text: "method_text_rls_reset" },
  "ekf-bank": { title: "method_title_ekf_bank", text: "method_text_ekf_bank" },
  "ekf-joint": { title: "method_title_ekf_joint", text: "method_text_ekf_joint" },
  "ukf-bank": { title: "method_title_ukf_bank", text: "method_text_ukf_bank" },
  "ukf-joint": { title: "method_title_ukf_joint", text: "method_text_ukf_joint" },
  agt: { title: "method_title_agt", text: "method_text_agt" },
  ga: { title: "method_title_ga", text: "method_text_ga" },
  pso: { title: "method_title_pso", text: "method_text_pso" },
  woa: { title: "method_title_woa", text: "method_text_woa" },
  nn: { title: "method_title_nn", text: "method_text_nn" },
  fuzzy: { title: "method_title_fuzzy", text: "method_text_fuzzy" },
  parity: { title: "method_title_parity", text: "method_text_parity" },
  luenberger: { title: "method_title_luenberger", text: "method_text_luenberger" },
  kalman: { title: "method_title_kalman", text: "method_text_kalman" },
  sliding: { title: "method_title_sliding", text: "method_text_sliding" },
  signal: { title: "method_title_signal", text: "method_text_signal" },
  swa: { title: "method_title_swa", text: "method_text_swa" },
  sia: { title: "method_title_sia", text: "method_text_sia" },
  faultlab: { title: "method_title_faultlab", text: "method_text_faultlab" },
};
