// @ts-check
/** Balls that are carried up and down a parameter, over the diagram: where they stay on different orbits, hysteresis. */
import { faded, theme } from "./colours.js";
import { linspace } from "./jobs.js";

/** Values of the parameter; turns that are passed over and kept at each. */
export const SWEEP = { values: 300, transient: 120, keep: 16 };
const KEPT = SWEEP.keep;

/** Positions nearer than this share of all that were taken are the same. */
const SAME = 3e-4;

/** The positions of an orbit with a period, in order; nothing of one without. @param {Float64Array} seen @param {number} same */
function cycle(seen, same) {
  for (let N = 1; 2 * N <= seen.length; N++) if (seen.subarray(N).every((u, n) => Math.abs(u - seen[n]) < same)) return seen.slice(0, N).sort();
  return null;
}

/** @typedef {{values: Float64Array, up: Float64Array, down: Float64Array}} Swept positions at the section: KEPT of them for each value, NaN where the orbit ended */

export class Sweeps {
  /** @type {Swept | null} */ found = null;
  /** @type {string | undefined} */ #key = undefined;

  /** @param {import("./pool.js").Pool} pool @param {() => void} done */
  constructor(pool, done) {
    this.pool = pool;
    this.done = done;
  }

  /** Sweep, unless that is swept already. @param {import("./machine.js").Floats} row @param {number} which @param {import("./state.js").Pair} span @param {number} seed */
  show(row, which, span, seed) {
    const others = Array.from(row);
    others[which] = 0;
    const key = JSON.stringify([others, which, span, seed]);
    if (key === this.#key) return;
    this.#key = key;
    this.found = null;
    const values = linspace(...span, SWEEP.values);
    this.pool.batch("sweeps").run("oscillator", "sweep", { row, which, values, seed, transient: SWEEP.transient, keep: SWEEP.keep }).then((swept) => {
      this.found = { values, ...swept };
      this.done();
    }, () => (this.#key = undefined));
  }

  /** @param {import("./plot.js").Axes} axes @param {import("./svg.js").Pen} c */
  draw(axes, c) {
    const shown = theme(), { box } = axes;
    c.globalAlpha = 0.72;
    c.fillStyle = shown.paper;
    c.fillRect(box.x, box.y, box.w, box.h);
    c.globalAlpha = 1;
    c.fillStyle = faded(shown.ink, 0.13);
    for (const [from, to] of this.differ()) c.fillRect(axes.x(from) - 1, box.y, axes.x(to) - axes.x(from) + 2, box.h);
    for (const [way, colour, size] of /** @type {["up" | "down", string, number][]} */ ([["up", shown.accent, 3], ["down", shown.graze, 1.4]])) {
      c.fillStyle = colour;
      this.found?.values.forEach((value, q) => {
        for (const u of this.found?.[way].subarray(q * KEPT, (q + 1) * KEPT) ?? []) {
          if (u >= axes.y0 && u <= axes.y1 && value >= axes.x0 && value <= axes.x1) c.fillRect(axes.x(value) - size / 2, axes.y(u) - size / 2, size, size);
        }
      });
    }
  }

  /** Where the two ways are on different orbits with a period, as intervals of the parameter. */
  differ() {
    /** @type {import("./state.js").Pair[]} */
    const found = [];
    if (!this.found) return found;
    const { values, up, down } = this.found, width = values[1] - values[0], taken = up.filter(Number.isFinite);
    const same = SAME * (taken.reduce((most, u) => Math.max(most, u), -Infinity) - taken.reduce((least, u) => Math.min(least, u), Infinity));
    values.forEach((value, q) => {
      const [a, b] = [up, down].map((all) => cycle(all.subarray(q * KEPT, (q + 1) * KEPT), same));
      if (!a || !b || (a.length === b.length && a.every((u, i) => Math.abs(u - b[i]) < same))) return;
      const last = found.at(-1);
      if (last && value - last[1] < 1.5 * width) last[1] = value;
      else found.push([value, value]);
    });
    return found;
  }

  /** What the colours are, above the picture. @param {import("./plot.js").Axes} axes @param {import("./svg.js").Pen} c */
  key(axes, c) {
    const shown = theme();
    c.textAlign = "right";
    c.textBaseline = "middle";
    let right = axes.box.x + axes.box.w;
    for (const [text, colour] of /** @type {[string, string][]} */ ([["down ←", shown.graze], ["up →", shown.accent], [this.differ().length ? "shaded: hysteresis" : "", shown.ink]])) {
      c.fillStyle = colour;
      c.fillText(text, right, axes.box.y - 9);
      right -= c.measureText(text).width + 14;
    }
  }
}
