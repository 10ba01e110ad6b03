// @ts-check
/** The state of the page, and the same as the fragment of a link: `#version=2&view=gap&lam=0.34&...`. */

import { BROUGHT, LAWS, above, below, ofLaws } from "./laws.js";
import { TOUR } from "./tour.js";
import { ROOM } from "./walls.js";

export const VERSION = "2";
/** What links of earlier versions left to the defaults of their time. @type {Record<string, object>} */
const EARLIER = { 1: { u0: 0.03 } };
export const VIEWS = ["ball", "oscillator", "gap", "edges", "chart", "strobe"];

/** @typedef {[number, number]} Pair */
/** @typedef {import("./machine.js").Field} Field */
/** @typedef {Record<string, Field>} Fields parameters by name, from kernels.json */

/** Orders of the discontinuity map, as the kernels number them. */
export const ORDERS = ["lowest", "full", "corrected"];

/** @param {number} low @param {number} high */
const pair = (low, high) => /** @type {Pair} */ ([low, high]);

/** Numbers of a ball beyond which squares of its speed are none: each of its flights would take seconds. */
const LARGEST = 1e100;

/** How far sliders reach; what a number field accepts is said in kernels.json. */
/** @type {Record<string, Pair>} */
export const GAP_EXTENTS = { lam: [0.02, 0.98], l: [0, 1.5], mu: [-0.2, 1.2] };
/** @type {Record<string, Pair>} */
export const OSCILLATOR_EXTENTS = {
  alpha: [0, 6], k: [0, 3], omega: [0.2, 6], t0: [0, 6], offset: [-0.5, 0.5], cos1: [-1.5, 1.5], sin1: [-1.5, 1.5],
  cos2: [-1.5, 1.5], sin2: [-1.5, 1.5], cos3: [-1.5, 1.5], sin3: [-1.5, 1.5], sigma: [-0.5, 0.5], r: [0, 1], V: [0, 1.5],
  trigger: [0, 1], sigma_B: [-0.5, 1.5], r_B: [0, 1], V_B: [0, 1.5], trigger_B: [0, 1], cos_A: [-0.5, 0.5], sin_A: [-0.5, 0.5], phase: [0, 6],
};

/** The longest period whose window is drawn. */
export const LONGEST = 60;

/** What sets no axis: the moment of the section, and the motion that both walls have. */
const SET = ["phase", "cos_A", "sin_A"];
export const VARIED = Object.keys(OSCILLATOR_EXTENTS).filter((name) => !SET.includes(name));

/**
 * What is shown unless a link says otherwise. `range` and `window` are null while they are found from the orbits, `ball`
 * (u, v and the time at which it is thrown) while the ball begins on the orbit that most starts settle on.
 */
export const DEFAULTS = {
  view: "ball",
  lam: 0.8, l: 0.2, mu: 0.3,
  span: pair(-0.1, 0.6), range: /** @type {Pair | null} */ (null), periods: pair(3, 5),
  alpha: 3, k: 1, omega: 2.2, t0: 0, offset: 0.12, cos1: 1, sin1: 0, cos2: 0, sin2: 0, cos3: 0, sin3: 0,
  sigma: 0, r: 0.8, V: 0.4, trigger: 0, law: "active", phase: 0,
  two: false, sigma_B: 0.2, r_B: 0.8, V_B: 0.2, trigger_B: 0, cos_A: 0, sin_A: 0,
  vary: "offset", reach: pair(0.05, 0.16), window: /** @type {Pair | null} */ (null), coordinate: "u", reduced: true,
  x0: 0.05, y0: 0, web: 0,
  u0: 0.012, v0: -0.23, line: pair(0.01, 0.06), order: "lowest", ball: /** @type {[number, number, number] | null} */ (null),
  chart: "gap", second: "V", positions: pair(0, 0.5), velocities: pair(-0.8, 0.8), gaps: pair(0, 1), heights: pair(0, 0.8), chart_columns: 240, chart_rows: 180,
  theory: true, colour: true, twin: false, sweeps: false,
  columns: 800, bins: 600, starts: 16, transient: 500, keep: 500, flow_starts: 8, flow_transient: 120, flow_keep: 64, seed: 0,
  tour: 0, answer: 0,
  note: "", pinned: "",
};

/** @typedef {typeof DEFAULTS} State */
/** @typedef {{colour?: string, text: string, exact?: string}} Line a line of what is shown, in words, with a chip of colour; `exact` is what nobody reads from afar */
/** @typedef {{change: (part: object) => import("./gestures.js").Undo, problem: (text: string) => void, done: () => void}} Events what a view tells the page */

/** In place of what a view gets when it is shown for the first time. @returns {any} */
export const later = () => undefined;

/** @type {Record<string, Pair>} */
const WHOLE = { columns: [2, 4000], bins: [2, 4000], starts: [1, 1000], transient: [0, 1e6], keep: [1, 1e5], flow_starts: [1, 1000], flow_transient: [0, 1e5], flow_keep: [1, 1e5], seed: [0, 2 ** 53 - 1], chart_columns: [2, 2000], chart_rows: [2, 2000], tour: [0, TOUR.length], answer: [0, 9], web: [0, 400] };
const PAIRS = ["span", "range", "reach", "window", "gaps", "heights", "line", "positions", "velocities"];
const SWITCHES = ["two", "reduced", "theory", "colour", "twin", "sweeps"];
/** @type {Record<string, string[]>} */
export const CHOICES = { view: VIEWS, law: Object.keys(LAWS), coordinate: ["u", "v"], vary: VARIED, second: VARIED, chart: ["gap", "oscillator", "basins"], order: ORDERS };

/** Where a link of a map is at home. */
const OF_A_MAP = "; a map of one’s own is shown by the page of “grazing explore --model”";
/** Characters of a link beyond which none is ours, and parts of one that are explained: what is shown is read by somebody. */
const LONGEST_LINK = 10_000, EXPLAINED = 8;
/** What a link writes so that nothing in it is taken for its own signs. */
const QUOTED = ["note", "pinned"];
/** Views whose diagram can be pinned, and what of a state is no setting. */
export const PINNABLE = ["gap", "oscillator", "map"], PASSING = /** @type {const} */ (["pinned", "note", "tour", "answer", "ball", "twin", "sweeps"]);
/** Characters of a note that a link may carry. */
export const LONGEST_NOTE = 280;

/** The parameters that a diagram can vary: those that the reset law and the walls have. @param {{law: string, two: boolean}} state */
export const varied = ({ law, two }) => VARIED.filter((name) => (two || !above(name)) && (!ofLaws(name) || LAWS[law].includes(below(name))));

/** Take up what the user brought: a map, which takes the place of all else, or the law of a model, and how far its sliders reach. @param {import("./laws.js").Model} model */
export function adopt(model) {
  BROUGHT.model = model;
  if (model.map) {
    VARIED.splice(0, Infinity, ...Object.keys(model.names));
    Object.assign(CHOICES, { view: ["map", "chart"], chart: VARIED.length > 1 ? ["map", "map-basins"] : ["map-basins"], coordinate: model.coordinates });
    Object.assign(DEFAULTS, model.state);
    return;
  }
  Object.assign(OSCILLATOR_EXTENTS, model.extents);
  if (!model.own.length) return;
  LAWS[model.law] = model.own;
  CHOICES.law.push(model.law);
  for (const name of Object.keys(model.extents).filter((each) => each.includes("."))) {
    VARIED.push(name);
    Object.assign(DEFAULTS, { [name]: model.state[name] });
  }
}

/** What the page opens on: its own state, or that of the model that was brought. @returns {State} */
export const opening = () => ({ ...structuredClone(DEFAULTS), ...structuredClone(BROUGHT.model?.state) });

/** The whole of an axis of the oscillator. @param {"reach" | "heights"} axis @param {string} name of its parameter @returns {Pair} */
export function wholeOf(axis, name) {
  if (BROUGHT.model) return (BROUGHT.model.reaches ?? OSCILLATOR_EXTENTS)[name];
  return name === (axis === "reach" ? DEFAULTS.vary : DEFAULTS.second) ? DEFAULTS[axis] : OSCILLATOR_EXTENTS[name];
}

/** Axes that zoom, with the whole of each. @param {State} state @returns {Record<string, Pair>} */
function whole(state) {
  const { span, line, positions, velocities, gaps } = DEFAULTS;
  return { span, line, positions, velocities, gaps, reach: wholeOf("reach", state.vary), heights: wholeOf("heights", state.second) };
}

/** What a picture zooms out to: the whole of each axis, or the state's own if that reaches further. @param {State} state */
export function zoomedOut(state) {
  const home = /** @type {any} */ (structuredClone(state));
  for (const [key, [low, high]] of Object.entries(whole(state))) {
    if (home[key][0] >= low && home[key][1] <= high) home[key] = [low, high];
  }
  return /** @type {State} */ ({ ...home, range: null, window: null });
}

/** Why a number is not allowed for a parameter, in words; empty if it is. @param {string} name @param {number} value @param {Fields} fields */
export function refusal(name, value, fields) {
  const field = fields[name];
  if (Number.isNaN(value)) return `${name} is not a number`;
  if (!Number.isFinite(value)) return `${name} is too large; numbers of double precision end at ±1.8e308`;
  if (name in OSCILLATOR_EXTENTS && Math.abs(value) > LARGEST) return `${name} = ${value}; allowed is |${name}| ≤ ${LARGEST}`;
  const low = field?.low ?? null, high = field?.high ?? null;
  if ((low !== null && (value < low || (field.open_low && value === low))) || (high !== null && value > high)) {
    const least = low === null ? "" : `${name} ${field.open_low ? ">" : "≥"} ${low}`;
    const most = high === null ? "" : `${name} ≤ ${high}`;
    return `${name} = ${value}; allowed is ${[least, most].filter(Boolean).join(" and ")}`;
  }
  return "";
}

/** The least width of an axis at these values that double precision resolves. @param {number} low @param {number} high */
export const narrowest = (low, high) => Math.max(1e-12, 1e-10 * Math.max(Math.abs(low), Math.abs(high)));

/**
 * The part of an interval that a parameter may take; one that lies outside is moved to the end of what it may.
 * @param {Field | undefined} field @param {Pair} ends @returns {Pair}
 */
export function allowed(field, [low, high]) {
  const width = high - low;
  const least = (field?.low ?? -Infinity) + (field?.open_low ? 1e-3 * width : 0), most = field?.high ?? Infinity;
  if (high <= least) return [least, Math.min(least + width, most)];
  if (low >= most) return [Math.max(least, most - width), most];
  return [Math.max(low, least), Math.min(high, most)];
}

/** Radians beyond which a double has no phase: some would be looked for without an end. Python refuses the same. */
const LATEST = 1e15;

/** Why a time is too late for a frequency, in words; empty if it is not. @param {"t0" | "phase" | "ball"} name @param {State} state */
const late = (name, state) => (Math.abs((name === "ball" ? (state.ball?.[2] ?? 0) : state[name]) * state.omega) > LATEST ? `allowed is |${name === "ball" ? "time" : name}| ≤ ${LATEST / state.omega} at omega = ${state.omega}: beyond, doubles are too coarse` : "");

/** One value of a fragment, or an Error that says what is wrong with it. @param {string} key @param {string} text @param {Fields} fields */
function read(key, text, fields) {
  const number = (/** @type {string} */ word) => (word.trim() === "" ? NaN : Number(word));
  if (CHOICES[key]) {
    if (!CHOICES[key].includes(text)) throw new Error(`${key}=${text}; allowed are ${CHOICES[key].join(", ")}${key === "law" ? ", and a law of one’s own on the page of “grazing explore --model”" : ""}${text.startsWith("map") ? OF_A_MAP : ""}`);
    return text;
  }
  if (SWITCHES.includes(key)) {
    if (text !== "yes" && text !== "no") throw new Error(`${key}=${text}; allowed are yes, no`);
    return text === "yes";
  }
  if (PAIRS.includes(key)) {
    const ends = text.split(":").map(number);
    if (ends.length !== 2 || !ends.every(Number.isFinite) || !(ends[0] < ends[1])) throw new Error(`${key}=${text}; give low:high with low < high`);
    const least = narrowest(ends[0], ends[1]);
    if (ends[1] - ends[0] < least) throw new Error(`${key}=${text} is too narrow for double precision; give ends that differ by ${least} or more`);
    return ends;
  }
  if (key === "periods") {
    const ends = text.split(":").map(number);
    if (ends.length !== 2 || !ends.every(Number.isInteger) || !(1 <= ends[0] && ends[0] <= ends[1] && ends[1] <= LONGEST)) throw new Error(`periods=${text}; give first:last, whole numbers from 1 to ${LONGEST}`);
    return ends;
  }
  if (key === "ball") {
    const start = text.split(":").map(number);
    if (start.length !== 3 || !start.every(Number.isFinite)) throw new Error(`ball=${text}; give u:v:time, three numbers`);
    return start;
  }
  if (key === "note") {
    if (text.length > LONGEST_NOTE) throw new Error(`the note has ${text.length} characters, of ${LONGEST_NOTE} at most`);
    return text;
  }
  if (key === "pinned") {
    const { state, problems } = fromFragment(`version=${VERSION}&${text}`, fields);
    if (problems.length) throw new Error(`of what is pinned ${problems.join("; ")}`);
    if (!PINNABLE.includes(state.view)) throw new Error(`the view ${state.view} is pinned; allowed are ${PINNABLE.join(", ")}`);
    return settingOf(state);
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
 * @param {string} fragment @param {Fields} fields
 */
export function fromFragment(fragment, fields) {
  const state = structuredClone(DEFAULTS), values = /** @type {Record<string, unknown>} */ (state);
  if (fragment.length > LONGEST_LINK) return { state, problems: [`it has ${fragment.length} characters, of ${LONGEST_LINK} at most`] };
  /** @type {string[]} */
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
  const version = given.get("version") ?? "";
  if (Object.hasOwn(EARLIER, version)) Object.assign(state, EARLIER[version]);
  else if (given.size && version !== VERSION) {
    problems.push(given.has("version") ? `the link has version ${version}; this page reads version ${VERSION}` : "the link does not say its version");
  }
  given.delete("version");
  for (const [key, text] of given) {
    if (!text && QUOTED.includes(key)) continue;
    if (!Object.hasOwn(DEFAULTS, key)) {
      problems.push(`${key} is no part of a link${key.startsWith("map.") ? OF_A_MAP : ""}`);
      continue;
    }
    try {
      values[key] = read(key, text, fields);
    } catch (error) {
      problems.push(/** @type {Error} */ (error).message);
    }
  }
  problems.push(...mended(state, fields, [...given.keys()]));
  const more = problems.splice(EXPLAINED).length;
  return { state, problems: more ? [...problems, `${more} more`] : problems };
}

/**
 * Make the parts of a state agree: axes with the reset law and with what their parameters may be, the step of the tour
 * with the view. Says what had to be changed of the parts that were `given`.
 * @param {State} state changed in place @param {Fields} fields @param {string[]} given
 */
export function mended(state, fields, given = []) {
  const names = varied(state);
  /** @type {string[]} */
  const said = [];
  const say = (/** @type {string} */ key, /** @type {string} */ text) => given.includes(key) && said.push(text);
  const without = (/** @type {string} */ key, /** @type {string} */ name) => say(key, `${key}=${name}; ${above(name) && !state.two ? "there is no second wall" : `the law ${state.law} has no ${name}`}`);
  if (!names.includes(state.vary)) {
    without("vary", state.vary);
    Object.assign(state, { vary: DEFAULTS.vary, reach: DEFAULTS.reach, window: null });
  }
  if (!names.includes(state.second)) {
    without("second", state.second);
    state.second = ["r", "omega", ...names].find((name) => name !== state.vary && names.includes(name)) ?? state.vary;
    state.heights = wholeOf("heights", state.second);
  }
  if (state.two && !(state.sigma_B - state.sigma >= ROOM)) {
    say("sigma_B", `sigma_B=${state.sigma_B}; the second wall is above the first: allowed is sigma_B ≥ ${tidy(state.sigma + ROOM, 1)}`);
    state.sigma_B = tidy(state.sigma + ROOM, 1);
  }
  for (const name of /** @type {const} */ (["t0", "phase", "ball"])) {
    const why = late(name, state);
    if (!why) continue;
    say(name, `${name}=${[state[name]].flat().join(":")}; ${why}`);
    Object.assign(state, { [name]: DEFAULTS[name] });
  }
  for (const [axis, name] of /** @type {["reach" | "heights", string][]} */ ([["reach", state.vary], ["heights", state.second]])) {
    const why = state[axis].flatMap((end) => [refusal(name, end, fields), late("t0", { ...state, [name]: end })]).filter(Boolean);
    const [low, high] = state[axis], most = state.sigma_B - ROOM, least = state.sigma + ROOM;
    if (state.two && name === "sigma" && high > most) {
      say(axis, `${axis}=${low}:${high}: the second wall is at sigma_B = ${state.sigma_B}`);
      state[axis] = [tidy(Math.min(low, most - 0.1), 1), tidy(most, 1)];
    }
    if (state.two && name === "sigma_B" && low < least) {
      say(axis, `${axis}=${low}:${high}: the first wall is at sigma = ${state.sigma}`);
      state[axis] = [tidy(least, 1), tidy(Math.max(high, least + 0.1), 1)];
    }
    if (!why.length) continue;
    say(axis, `${axis}=${state[axis].join(":")}: ${why[0]}`);
    state[axis] = wholeOf(axis, name);
  }
  const step = TOUR[state.tour - 1];
  const asked = step?.question;
  if (state.answer > (asked?.choices.length ?? 0)) {
    say("answer", `answer=${state.answer}; ${asked ? `there are ${asked.choices.length} answers` : "nothing is asked"}`);
    state.answer = 0;
  }
  const wanted = (state.answer && asked?.shown.view) || step?.state.view;
  if (step && wanted !== state.view) {
    say("tour", `tour=${state.tour} shows the view ${wanted}, not ${state.view}`);
    Object.assign(state, { tour: 0, answer: 0 });
  }
  return said;
}

/** The fragment of a state: what differs from the defaults. @param {State} state */
export function toFragment(state) {
  const usual = /** @type {Record<string, unknown>} */ (DEFAULTS);
  const parts = [`version=${VERSION}`, `view=${state.view}`];
  for (const [key, value] of Object.entries(state)) {
    const { model } = BROUGHT, own = model?.map ? key in model.state : key.includes(".") && LAWS[state.law].includes(below(key)) && (state.two || !above(key)); // the file may change
    if (key === "view" || (!own && JSON.stringify(value) === JSON.stringify(usual[key]))) continue;
    const text = Array.isArray(value) ? value.join(":") : typeof value === "boolean" ? (value ? "yes" : "no") : value;
    parts.push(`${key}=${QUOTED.includes(key) ? encodeURIComponent(String(text)) : text}`);
  }
  return `#${parts.join("&")}`;
}

/** The setting of a state, as `pinned` holds it. @param {State} state */
export function settingOf(state) {
  const own = structuredClone(state);
  for (const key of PASSING) Object.assign(own, { [key]: DEFAULTS[key] });
  return toFragment(own).replace(`#version=${VERSION}&`, "");
}

/** The state whose setting is pinned. @param {string} pinned @param {Fields} fields */
export const kept = (pinned, fields) => fromFragment(`version=${VERSION}&${pinned}`, fields).state;

/** A number with no more digits than a picture of this width needs. @param {number} value @param {number} width */
export function tidy(value, width) {
  return Number(value.toFixed(Math.min(15, Math.max(0, 4 - Math.floor(Math.log10(Math.abs(width) || 1))))));
}

/** A number in words: six digits, and more where a picture of this width needs them, as in the boxes. @param {number} value @param {Pair} ends of its axis */
export const told = (value, [low, high]) => numeral(value, Math.min(15, Math.max(6, 5 + Math.floor(Math.log10(Math.abs(value) || 1)) - Math.floor(Math.log10(high - low)))));

/** A number as text, with a true minus. @param {number} value @param {number} digits */
export const numeral = (value, digits = 6) => Number(value.toPrecision(digits)).toString().replace("-", "−");
