// @ts-check
/** Basins: attractors from the pieces that workers have computed, with their colours. */
import { PERIODS, periodColour, rgb } from "./colours.js";

/** @typedef {import("./jobs.js").Reached} Reached */
/** @typedef {Reached & {cells: number, colour: string}} Attractor with how many states reach it */

/** Points of one attractor differ by less than this share of the picture, as in `gz.basins`. */
const SAME = 1e-6;

/** How far points of one attractor may differ, in both directions. @param {number[][]} ends of the picture @param {Float64Array} box where starts are drawn @returns {import("./machine.js").Floats} */
export const sameWithin = (ends, box) => Float64Array.from(ends, ([low, high], i) => SAME * Math.max(high - low, box[2 * i + 1] - box[2 * i]));

/** Find rows of a piece among those known already, adding what is new; returns their numbers. @param {Reached[]} known @param {Reached[]} reached @param {Float64Array} same */
export function merged(known, reached, same) {
  return reached.map((each) => {
    const at = known.findIndex(({ period, word, point }) => period === each.period && word === each.word && point.every((x, i) => Math.abs(x - each.point[i]) <= same[i]));
    return at >= 0 ? at : known.push(each) - 1;
  });
}

/** Attractors in order of their basins, the largest first, with their colours; `cells` counts the states of each row. @param {Reached[]} known @param {number[]} cells @returns {(Attractor & {row: number})[]} */
export function ordered(known, cells) {
  const sorted = known.map((each, row) => ({ ...each, row, cells: cells[row], colour: "" })).filter((each) => each.cells > 0);
  const order = (/** @type {number[]} */ a, /** @type {number[]} */ b) => a.reduce((sign, x, i) => sign || x - b[i], 0);
  sorted.sort((a, b) => b.cells - a.cells || a.period - b.period || (a.word < b.word ? -1 : a.word > b.word ? 1 : 0) || order(a.point, b.point));
  const base = sorted.map(({ period }) => periodColour(period));
  sorted.forEach((each, i) => {
    const rank = base.slice(0, i).filter((colour) => colour === base[i]).length;
    const last = base.filter((colour) => colour === base[i]).length - 1;
    each.colour = rank ? shade(base[i], last > 1 ? (rank - 1) / (last - 1) : 1) : base[i];
  });
  return sorted;
}

/** A shade of a colour, from the nearest, 0, to the farthest, 1: dark ones lighter, light ones darker, as in the figures. @param {string} colour @param {number} far */
function shade(colour, far) {
  const parts = rgb(colour);
  const light = parts.reduce((sum, part, i) => sum + [0.2126, 0.7152, 0.0722][i] * (part / 255) ** 2.2, 0) > 0.25;
  const end = rgb(light ? "#1a1a1a" : colour === PERIODS[0] ? "#d2a679" : "#ffffff");
  const share = light ? 0.32 + 0.23 * far : 0.4 + 0.35 * far;
  return `#${parts.map((part, i) => Math.round((1 - share) * part + share * end[i]).toString(16).padStart(2, "0")).join("")}`;
}

/** A share as a percentage with three digits, never rounded to nothing. @param {number} share */
export function percent(share) {
  if (share > 0 && share < 1e-4) return "< 0.01 %";
  return `${Number((100 * share).toFixed(share >= 0.01 ? 1 : 2))} %`;
}
