// @ts-check
/** The orbits that random starts settle on at one parameter value, named by period and word. */
import { settled } from "./jobs.js";

/** @typedef {{period: number, word: string, share: number, points: number[][], impacts: number | null, length: number, multiplier?: number}} Class orbits of one period and word, with one cycle */

/** A word in its least rotation; letters above 9 as (12). @param {number[]} letters */
function least(letters) {
  const turns = letters.map((_, i) => [...letters.slice(i), ...letters.slice(0, i)]);
  turns.sort((a, b) => {
    const at = a.findIndex((letter, i) => letter !== b[i]);
    return at < 0 ? 0 : a[at] - b[at];
  });
  return turns[0] ?? [];
}

/**
 * Classes of orbits, most starts first.
 * @param {import("./machine.js").Machine} machine
 * @param {{row: import("./machine.js").Floats, which: number, value: number, starts?: number, transient: number, keep?: number, seed: number, tolerance: number}} job
 */
export function found(machine, { row, which, value, starts = 16, transient, keep = 128, seed, tolerance }) {
  const given = { row, which, values: Float64Array.of(value), starts, transient, keep, seed, tolerance };
  const made = settled(machine, given);
  const dimension = machine.described.coordinates.length;
  /** @type {Class[]} */
  const classes = [];
  for (let i = 0; i < starts && made.count[i] > 0; i++) {
    const j = made.first[i];
    const period = made.period[j];
    const begin = made.begin[j] - Math.max(period, 0); // the letters repeat, and here none of the word lies beyond the end
    const letters = Array.from({ length: made.length[j] }, (_, n) => made.letters[(begin + n) * starts + j]);
    const names = machine.described.letters;
    const word = least(letters).map((k) => (names ? names[k] : k > 9 ? `(${k})` : String(k))).join("");
    const length = period > 0 ? Math.min(period, keep) : keep;
    const points = Array.from({ length }, (_, n) => Array.from({ length: dimension }, (_, d) => made.points[(n * dimension + d) * starts + j]));
    classes.push({ period, word, share: made.count[i] / starts, points, impacts: names ? null : letters.reduce((sum, k) => sum + (k < 0 ? 0 : k), 0), length: letters.length });
  }
  return classes;
}

const fixed = (/** @type {number} */ value) => Number(value.toPrecision(7)).toString().replace("-", "−");

/** A class in words. @param {Class} each */
export function words(each, starts = 16) {
  const share = `${Math.round(each.share * starts)} of ${starts} starts`;
  if (each.period === -1) return `no period found (aperiodic as far as seen); ${share}`;
  if (each.period === 0) return `undecided; ${share}`;
  if (each.period < 0) return `orbit that ended; ${share}`;
  let text = `period-${each.period} orbit`;
  if (each.impacts !== null) text += each.impacts === 0 ? ", no impact" : `, ${each.impacts === 1 ? "one impact" : `${each.impacts} impacts`}${each.length !== each.period ? ` in ${each.length} periods` : ""}`;
  if (each.word) text += `, word ${each.word}`;
  if (each.multiplier !== undefined) text += `, multiplier ${fixed(each.multiplier)}`;
  text += `; ${share}`;
  if (each.period <= 6) text += `; at ${each.points.map((point) => (point.length > 1 ? `(${point.map(fixed).join(", ")})` : fixed(point[0]))).join(", ")}`;
  return text;
}
