// @ts-check
/** The state of the page, and the same as the fragment of a link: `#version=1&view=gap&lam=0.34&...`. */

import { TOUR } from "./tour.js";

export const VERSION = "1";
export const VIEWS = ["gap", "oscillator", "ball", "chart", "strobe"];

/** How far sliders reach; what a number field accepts is said in kernels.json. */
export const GAP_EXTENTS = { lam: [0.02, 0.98], l: [0, 1.5], mu: [-0.2, 1.2] };
export const OSCILLATOR_EXTENTS = {
  alpha: [0, 6], k: [0, 3], omega: [0.2, 6], t0: [0, 6], offset: [-0.5, 0.5], cos1: [-1.5, 1.5], sin1: [-1.5, 1.5],
  cos2: [-1.5, 1.5], sin2: [-1.5, 1.5], cos3: [-1.5, 1.5], sin3: [-1.5, 1.5], sigma: [-0.5, 0.5], r: [0, 1], V: [0, 1.5],
  trigger: [0, 1], phase: [0, 6],
};

export const VARIED = Object.keys(OSCILLATOR_EXTENTS).filter((name) => name !== "phase");

/** What is shown unless a link says otherwise. `range` is null while it is found from the orbits. */
export const DEFAULTS = {
  view: "gap",
  lam: 0.8, l: 0.2, mu: 0.3,
  span: [-0.1, 0.6], range: null,
  alpha: 3, k: 1, omega: 2.2, t0: 0, offset: 0.12, cos1: 1, sin1: 0, cos2: 0, sin2: 0, cos3: 0, sin3: 0,
  sigma: 0, r: 0.8, V: 0.4, trigger: 0, law: "active", phase: 0,
  vary: "offset", reach: [0.05, 0.16], window: null, coordinate: "u", reduced: true,
  v0: -0.23, line: [0.01, 0.06], order: "lowest",
  chart: "gap", second: "V", positions: [0, 0.5], velocities: [-0.8, 0.8], gaps: [0, 1], heights: [0, 0.8], chart_columns: 240, chart_rows: 180,
  theory: true, colour: true,
  columns: 800, bins: 600, starts: 16, transient: 500, keep: 500, flow_starts: 8, flow_transient: 120, flow_keep: 64, seed: 0,
  tour: 0,
};

const WHOLE = { columns: [2, 4000], bins: [2, 4000], starts: [1, 1000], transient: [0, 1e6], keep: [1, 1e5], flow_starts: [1, 1000], flow_transient: [0, 1e5], flow_keep: [1, 1e5], seed: [0, 2 ** 53 - 1], chart_columns: [2, 2000], chart_rows: [2, 2000], tour: [0, TOUR.length] };
const PAIRS = ["span", "range", "reach", "window", "gaps", "heights", "line", "positions", "velocities"];
const SWITCHES = ["reduced", "theory", "colour"];
const CHOICES = { view: VIEWS, law: ["newton", "active", "triggered"], coordinate: ["u", "v"], vary: VARIED, second: VARIED, chart: ["gap", "oscillator", "basins"], order: ["lowest", "full", "corrected"] };

/** Why a number is not allowed for a parameter, in words; empty if it is. */
export function refusal(name, value, fields) {
  const field = fields[name];
  if (!Number.isFinite(value)) return `${name} is not a number`;
  const low = field?.low ?? null, high = field?.high ?? null;
  if ((low !== null && (value < low || (field.open_low && value === low))) || (high !== null && value > high)) {
    const least = low === null ? "" : `${name} ${field.open_low ? ">" : "≥"} ${low}`;
    const most = high === null ? "" : `${name} ≤ ${high}`;
    return `${name} = ${value}; allowed is ${[least, most].filter(Boolean).join(" and ")}`;
  }
  return "";
}

/** One value of a fragment, or an Error that says what is wrong with it. */
function read(key, text, fields) {
  const number = (word) => (word.trim() === "" ? NaN : Number(word));
  if (CHOICES[key]) {
    if (!CHOICES[key].includes(text)) throw new Error(`${key}=${text}; allowed are ${CHOICES[key].join(", ")}`);
    return text;
  }
  if (SWITCHES.includes(key)) {
    if (text !== "yes" && text !== "no") throw new Error(`${key}=${text}; allowed are yes, no`);
    return text === "yes";
  }
  if (PAIRS.includes(key)) {
    const ends = text.split(":").map(number);
    if (ends.length !== 2 || !ends.every(Number.isFinite) || !(ends[0] < ends[1])) throw new Error(`${key}=${text}; give low:high with low < high`);
    return ends;
  }
  const value = number(text);
  if (WHOLE[key]) {
    const [least, most] = WHOLE[key];
    if (!Number.isInteger(value) || value < least || value > most) throw new Error(`${key}=${text}; allowed is a whole number from ${least} to ${most}`);
    return value;
  }
  const why = refusal(key, value, fields);
  if (why) throw new Error(Number.isNaN(value) ? `${key}=${text} is not a number` : why);
  return value;
}

/**
 * The state that a fragment describes, and what is wrong with the fragment, in words. What is wrong is left at its
 * default, so that a mangled link still shows a picture.
 */
export function fromFragment(fragment, fields) {
  const state = structuredClone(DEFAULTS);
  const problems = [];
  const parts = fragment.replace(/^#/, "").split("&").filter(Boolean);
  const given = new Map();
  for (const part of parts) {
    const at = part.indexOf("=");
    let text = part.slice(at + 1);
    try {
      text = decodeURIComponent(text);
    } catch {
      problems.push(`${part} cannot be read`);
      continue;
    }
    given.set(at < 0 ? part : part.slice(0, at), at < 0 ? "" : text);
  }
  if (given.size && given.get("version") !== VERSION) {
    problems.push(given.has("version") ? `the link has version ${given.get("version")}; this page reads version ${VERSION}` : "the link does not say its version");
  }
  given.delete("version");
  for (const [key, text] of given) {
    if (!(key in DEFAULTS)) {
      problems.push(`${key} is no part of a link`);
      continue;
    }
    try {
      state[key] = read(key, text, fields);
    } catch (error) {
      problems.push(error.message);
    }
  }
  return { state, problems };
}

/** The fragment of a state: what differs from the defaults. */
export function toFragment(state) {
  const parts = [`version=${VERSION}`, `view=${state.view}`];
  for (const [key, value] of Object.entries(state)) {
    if (key === "view" || JSON.stringify(value) === JSON.stringify(DEFAULTS[key])) continue;
    parts.push(`${key}=${Array.isArray(value) ? value.join(":") : typeof value === "boolean" ? (value ? "yes" : "no") : value}`);
  }
  return `#${parts.join("&")}`;
}

/** A number with no more digits than a picture of this width needs. */
export function tidy(value, width) {
  return Number(value.toFixed(Math.min(15, Math.max(0, 4 - Math.floor(Math.log10(Math.abs(width) || 1))))));
}
