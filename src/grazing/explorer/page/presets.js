// @ts-check
/** Figures of the paper, by number: what differs from the defaults. */

const STANDARD = { alpha: 3, k: 1, omega: 2.2, t0: 0, r: 0.8, law: "active" };
const SHALLOW = { ...STANDARD, view: "strobe", omega: 2.1, t0: 2.2, offset: 0.11, V: 0.2, u0: 0.03, v0: -0.23 };
const gap = (/** @type {number} */ lam, /** @type {number} */ l, /** @type {[number, number]} */ span, /** @type {number} */ mu, more = {}) => ({ view: "gap", lam, l, span, mu, ...more });

/** @type {Record<string, {title: string, state: Partial<import("./state.js").State>}>} */
export const PRESETS = {
  "1.2": { title: "Passive oscillator, period 2", state: { ...STANDARD, view: "ball", V: 0, offset: 0.12 } },
  "1.3": { title: "Passive oscillator, orbit diagram", state: { ...STANDARD, view: "oscillator", V: 0, offset: 0.12 } },
  "1.5": { title: "Active oscillator, period 3", state: { ...STANDARD, view: "ball", V: 0.4, offset: 0.12 } },
  "1.6": { title: "Active oscillator, orbit diagram", state: { ...STANDARD, view: "oscillator", V: 0.4, offset: 0.12 } },
  "2.1": { title: "Zero-time map of a low impact, the further picture", state: SHALLOW },
  "2.2": { title: "Stroboscopic against discontinuity map", state: SHALLOW },
  "3.1": { title: "Cobweb, λ = 0.8, l = 1, μ = 0.5", state: gap(0.8, 1, [-0.1, 1.2], 0.5) },
  "3.2": { title: "Gap map, λ = 0.34, l = 0.21", state: gap(0.34, 0.21, [-0.1, 0.6], 0.2) },
  "3.3a": { title: "Gap map, λ = 0.5, l = 0", state: gap(0.5, 0, [-0.05, 0.35], 0.15) },
  "3.3b": { title: "Gap map, λ = 0.5, l = 0.1", state: gap(0.5, 0.1, [-0.05, 0.35], 0.15) },
  "3.3c": { title: "Gap map, λ = 0.5, l = 0.5", state: gap(0.5, 0.5, [-0.05, 0.35], 0.15) },
  "3.4": { title: "Edges of 3 and 4 against the gap, λ = 0.5", state: { view: "edges", lam: 0.5, periods: [3, 4], gaps: [0, 0.5], span: [0, 0.4], l: 0.1, mu: 0.1 } },
  "3.5a": { title: "Gap map, λ = 0.9, l = 0: robust chaos", state: gap(0.9, 0, [-0.05, 0.6], 0.1) },
  "3.5b": { title: "Gap map, λ = 0.9, l = 0.4", state: gap(0.9, 0.4, [-0.05, 0.6], 0.2) },
  "3.5c": { title: "Gap map, λ = 0.9, l = 0.8", state: gap(0.9, 0.8, [-0.05, 0.6], 0.2) },
  "3.6": { title: "Edges of 3, 4 and 5 against the gap, λ = 0.9", state: { view: "edges", lam: 0.9, periods: [3, 5], gaps: [0, 1], span: [0, 1], l: 0.7, mu: 0.42 } },
  "3.7": { title: "Close-up near the graze, λ = 0.9, l = 0.8", state: gap(0.9, 0.8, [0.002, 0.06], 0.03, { transient: 3000 }) },
};
