// @ts-check
/** The orbits that random starts settle on at one parameter value, in words, and the search for them. */
import { periodColour } from "./colours.js";
import { found } from "./jobs.js";
import { numeral } from "./state.js";
import { crossings } from "./walls.js";

/** @typedef {import("./jobs.js").Class} Class */
/** @typedef {Parameters<typeof found>[1]} Asked what is searched */

/** A search that is expected to take longer is left to the pool, in milliseconds. */
const SOON = 30;
/** Time in which the oscillator is followed, at most, unless it is fewer periods than `FEWEST`. */
const LONGEST = 2e4, FEWEST = 16;

/** So many periods of the forcing, or fewer where each is long: starts come to rest in time, not in periods. @param {number} periods @param {number} T */
export const within = (periods, T) => Math.min(periods, Math.max(FEWEST, Math.ceil(LONGEST / T)));

/** What a period of the forcing costs, beside one of the standard set: it is longer, or there are more impacts in it. @param {import("./state.js").State} state */
export const costOf = (state) => Math.max(1, (2 * Math.PI) / state.omega / 2.9, crossings(state));

/** Finds what random starts settle on: at once where that is quick, else in the pool, so that the page answers meanwhile. */
export class Search {
  /** @type {Class[]} */ classes = [];
  /** Whether the pool is still at it. */ waiting = false;
  /** Milliseconds for one start in one step of unit cost, as measured last. */
  #rate = 1e-3;
  /** @type {string | undefined} */ #key = undefined;
  /** Whether the pool's answer is still wanted. */ #live = () => false;

  /**
   * @param {Pick<import("./pool.js").Pool, "batch">} pool
   * @param {string} channel
   * @param {{found: () => void, problem: (text: string) => void}} told what is done when the pool has found them
   */
  constructor(pool, channel, told) {
    this.pool = pool;
    this.channel = channel;
    this.told = told;
  }

  /** Search once more, even for the same. */
  forget() {
    this.#key = undefined;
  }

  /** Begin, unless the same was asked last; what was asked before is dropped. @param {string} name of the module @param {import("./machine.js").Machine} machine @param {Asked} asked @param {number} cost of a step */
  ask(name, machine, asked, cost = 1) {
    const key = JSON.stringify([Array.from(asked.row), { ...asked, row: null }]);
    if (key === this.#key && (!this.waiting || this.#live())) return;
    this.#key = key;
    const batch = this.pool.batch(this.channel, true), begun = performance.now();
    this.#live = batch.live;
    const steps = (asked.starts ?? 16) * (asked.transient + (asked.keep ?? 128)) * cost;
    this.waiting = steps * this.#rate > SOON;
    if (!this.waiting) {
      this.classes = found(machine, asked);
      this.#rate = (performance.now() - begun) / steps;
      return;
    }
    this.classes = [];
    batch.run(name, "found", asked).then(
      (classes) => {
        this.waiting = false;
        this.classes = classes;
        this.#rate = (performance.now() - begun) / steps;
        this.told.found();
      },
      (error) => {
        this.waiting = false;
        this.told.problem(`What starts settle on could not be found: ${error.message}.`);
      },
    );
  }
}

/** Where starts are drawn: shares are of that. @param {import("./machine.js").Machine} machine @param {import("./machine.js").Floats} rows */
export function drawnFrom(machine, rows) {
  const [a, b, c, d] = Array.from(machine.call("boxes", { columns: 1, rows }, ["boxes"]).boxes, (end) => numeral(end, 3));
  return { text: `The 16 starts are random, with ${a} ≤ u ≤ ${b} and ${c} ≤ v ≤ ${d}; Charts count those of their picture.` };
}

/** In place of the classes while they are searched. */
export const SEARCHING = "Looking for what random starts settle on …";

/** The word of a ball that only lies. */
export const RESTS = /^(S|\(S[AB]\))+$/;

/** The impacts of a class, in words; nothing for a map that does not count them. @param {Class} each */
function impactsOf({ impacts, word, length, period }) {
  if (impacts === undefined) return "";
  const turns = length !== period ? ` in ${length} period${length > 1 ? "s" : ""}` : "";
  if (impacts !== null) return impacts === 0 ? ", no impact" : `, ${impacts === 1 ? "one impact" : `${impacts} impacts`}${turns}`;
  if (RESTS.test(word)) return ", at rest on the wall";
  return /[CS]/.test(word) ? `, impacts that die away in completed chatter${word.includes("S") ? ", and rest on the wall" : ""}` : "";
}

/** Whether a word says nothing: that of a map that gives its steps no letters. @param {Class} each */
const bare = ({ impacts, word }) => impacts === undefined && word === "0";

/** A class in words. @param {Class} each @returns {import("./state.js").Line} */
function line(each) {
  const share = `${Math.round(each.starts * each.share)} of ${each.starts} starts`, colour = periodColour(each.period);
  if (each.period < 1) return { colour, text: `${each.period === -1 ? "no period found (aperiodic as far as seen)" : each.period === 0 ? "undecided" : "orbit that ended"}; ${share}` };
  let text = `period-${each.period} orbit${impactsOf(each)}`;
  if (each.word && !bare(each)) text += `, word ${each.word}`;
  if (each.multiplier !== undefined) text += `, multiplier ${numeral(each.multiplier)}`;
  text += `; ${share}`;
  return { colour, text, exact: each.period > 6 ? "" : `; at ${each.points.map((point) => (point.length > 1 ? `(${point.map((each) => numeral(each)).join(", ")})` : numeral(point[0]))).join(", ")}` };
}

/** Classes in words. @param {Class[]} classes */
export const words = (classes) => classes.map(line);
