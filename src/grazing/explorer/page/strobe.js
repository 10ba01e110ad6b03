// @ts-check
/** One period of the forcing: the stroboscopic map against the discontinuity map along a line of starts, Figure 2.2, and the zero-time map of one start, Figure 2.1. */
import { periodColour, theme } from "./colours.js";
import { rowOf } from "./flow.js";
import { Gestures } from "./gestures.js";
import { CHATTER, linspace } from "./jobs.js";
import { Axes } from "./plot.js";
import { ORDERS, numeral, told } from "./state.js";
import { still } from "./walls.js";
import { drawZeroTime, zeroTime } from "./zdm.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./machine.js").Machine} Machine */

const SAMPLES = 600;
/** How near the wall a ball ends its period whose impact passes the end of that. */
const AT_WALL = 1e-6;
/** @typedef {import("./machine.js").Floats} Floats */
/** @typedef {{u: Floats, v: Floats, letters: Int32Array}} Images after one period, and impacts in it */
/** @typedef {{map: "orbits" | "orbits_local", at: number, below: number, above: number, strobe: boolean}} Jump first start beyond a change of letter, and whether there an impact comes at the end of the period, and not at a graze */

const impacts = (/** @type {number} */ letter) => (letter < 0 ? (letter === CHATTER ? "completed chatter" : "rest on the wall") : `${letter} impact${letter === 1 ? "" : "s"}`);

export class StrobeView {
  /** The starts. */
  u = new Float64Array(0);
  /** The parameters, with the order of the discontinuity map. */
  rows = new Float64Array(0);

  /** @param {Machine} machine @param {Pick<import("./state.js").Events, "change">} events */
  constructor(machine, { change }) {
    this.machine = machine;
    this.axes = new Axes(document.getElementById("strobe"));
    this.zero = new Axes(document.getElementById("zero-time"));
    this.gestures = new Gestures(this.axes, {
      ready: () => Boolean(this.state),
      redraw: () => this.paint(),
      pick: (u0) => change({ u0 }),
      zoom: (line) => change({ line }),
      follows: () => true,
      zoomOut: () => change({ line: null }),
      chosen: () => [this.state?.u0 ?? NaN, NaN],
      steps: () => [SAMPLES - 1, 1],
    });
  }

  get canvas() {
    return this.axes.canvas;
  }

  /** @returns {import("./svg.js").Panel[]} */
  panels() {
    return [{ sheet: this.axes, draw: () => this.#drawMaps() }, { sheet: this.zero, draw: () => this.#drawZero() }];
  }

  /** One period from each start (u, v0). @param {Floats} u @param {"orbits" | "orbits_local"} map @returns {Images} */
  #once(u, map) {
    const starts = u.length;
    const lanes = new Float64Array(2 * starts).fill(/** @type {State} */ (this.state).v0);
    lanes.set(u);
    const { points, letters } = this.machine.call(map, { columns: 1, starts, keep: 1, rows: this.rows, lanes, transient: 0 }, ["points", "letters"]);
    return { u: points.subarray(0, starts), v: points.subarray(starts), letters };
  }

  /** Where a map's letter changes along the line, halved until rounding decides. @param {"orbits" | "orbits_local"} map @param {Images} images @returns {Jump[]} */
  #jumps(map, { letters }) {
    const found = [];
    for (let i = 1; i < letters.length && found.length < 4; i++) {
      if (letters[i] === letters[i - 1]) continue;
      let before = this.u[i - 1], after = this.u[i];
      for (;;) {
        const middle = 0.5 * (before + after);
        if (middle === before || middle === after) break;
        if (this.#once(Float64Array.of(middle), map).letters[0] === letters[i - 1]) before = middle;
        else after = middle;
      }
      const ends = this.#once(Float64Array.of(before, after), map).u, { sigma } = /** @type {State} */ (this.state);
      found.push({ map, at: after, below: letters[i - 1], above: letters[i], strobe: ends.some((u) => Math.abs(u - sigma) < AT_WALL) });
    }
    return found;
  }

  /** @param {State} state */
  show(state) {
    if (!still(state)) throw new Error("the discontinuity map is that of one wall at rest; take the second wall away, and let the first one rest under “More settings”");
    if (state.line[1] <= state.sigma) throw new Error(`u(0) runs to ${state.line[1]}, behind the wall at ${state.sigma}; choose starts above the wall`);
    this.state = state;
    const { machine } = this;
    this.rows = rowOf(machine, state);
    this.rows[machine.fields.indexOf("order")] = ORDERS.indexOf(state.order);
    const row = rowOf(machine, state);
    this.u = linspace(Math.max(state.line[0], state.sigma), state.line[1], SAMPLES);
    this.full = this.#once(this.u, "orbits");
    this.local = this.#once(this.u, "orbits_local");
    this.jumps = [...this.#jumps("orbits", this.full), ...this.#jumps("orbits_local", this.local)];
    this.four = zeroTime(machine, row, state.u0, state.v0);
    this.flow = this.four ? this.#flow(row, state) : [];
    this.paint();
  }

  /** The exact flow from the start over the first half of a period, broken at impacts. @param {Floats} row @param {State} state */
  #flow(row, state) {
    const until = Math.PI / state.omega, samples = 400;
    const start = Float64Array.of(0, 0, state.u0 - state.sigma, state.v0, 0, 0, 0, 0);
    const { result, legs } = this.machine.call("legs", { capacity: 64, row, state: start, until, patience: 1e-6 }, ["legs"]);
    const flown = legs.subarray(0, Number(result) * 11);
    /** @type {{t: number, before: number, after: number}[]} */
    const hits = [];
    for (let k = 0; k < flown.length; k += 11) if (!Number.isNaN(flown[k + 5])) hits.push({ t: flown[k + 4], before: flown[k + 5], after: flown[k + 6] });
    const times = linspace(0, until, samples);
    const { u, v } = this.machine.call("sample", { count: Number(result), samples, row, legs: flown, times }, ["u", "v"]);
    const pieces = [/** @type {[number, number][]} */ ([])];
    times.forEach((t, i) => {
      while (hits.length && hits[0].t <= t) {
        const hit = /** @type {typeof hits[number]} */ (hits.shift());
        pieces[pieces.length - 1].push([state.sigma, hit.before]);
        pieces.push([[state.sigma, hit.after]]);
      }
      pieces[pieces.length - 1].push([u[i], v[i]]);
    });
    return pieces;
  }

  repaint() {
    if (this.state) this.paint();
  }

  paint() {
    this.#drawMaps();
    this.#drawZero();
    this.canvas.dataset.stage = "done";
  }

  #drawMaps() {
    const { axes, full, local, jumps } = this, state = /** @type {State} */ (this.state);
    if (!full || !local || !jumps) return;
    const [one, other] = state.coordinate === "v" ? [full.v, local.v] : [full.u, local.u];
    const seen = [...one, ...other].filter(Number.isFinite);
    const low = Math.min(...seen), high = Math.max(...seen), room = 0.06 * (high - low) || 0.01;
    const c = axes.begin();
    axes.span(this.u[0], this.u[SAMPLES - 1], low - room, high + room);
    const curves = /** @type {[Float64Array, Int32Array, string, number, string][]} */ ([
      [one, full.letters, theme().ink, 3.4, "stroboscopic map"],
      [other, local.letters, periodColour(2), 1.8, `discontinuity map, ${state.order}`],
    ]);
    axes.inside(() => {
      for (const { map, at, strobe } of jumps) axes.vertical(at, map === "orbits" ? theme().graze : periodColour(2), strobe ? [1, 4] : [5, 3], 1);
      for (const [values, letters, colour, width] of curves) {
        c.strokeStyle = colour;
        c.lineWidth = width;
        c.beginPath();
        values.forEach((value, i) => {
          const [x, y] = [axes.x(this.u[i]), axes.y(value)];
          if (i && letters[i] === letters[i - 1] && Number.isFinite(values[i - 1])) c.lineTo(x, y);
          else c.moveTo(x, y);
        });
        c.stroke();
      }
    });
    axes.vertical(state.u0, theme().accent, [], 1.6);
    axes.frame("u(0)", `${state.coordinate}(T)`);
    this.#key(c, curves.map(([, , colour, , text]) => [colour, text]));
    this.gestures.draw(c);
  }

  /** What the curves are, above the picture, where nothing else is; in short where there is little room. @param {import("./svg.js").Pen} c @param {[string, string][]} curves */
  #key(c, curves) {
    const { x, w } = this.axes.box;
    c.textAlign = "left";
    c.textBaseline = "middle";
    const wide = curves.reduce((sum, [, text]) => sum + c.measureText(text).width + 31, -14);
    let left = x;
    for (const [colour, text] of curves) {
      const said = wide > w ? text.replace("stroboscopic map", "exact").replace("discontinuity map", "local map") : text;
      c.fillStyle = colour;
      c.fillRect(left, 8, 11, 5);
      c.fillStyle = theme().faint;
      c.fillText(said, left + 17, 11);
      left += 31 + c.measureText(said).width;
    }
  }

  /** Why the zero-time map of the start moves nothing. */
  #still() {
    const { u0, v0, sigma } = /** @type {State} */ (this.state);
    if (u0 < sigma) return [`u(0) = ${numeral(u0)} lies behind the wall at ${numeral(sigma)}:`, "there is no zero-time map of it."];
    return ["The zero-time map of this start is the identity:", v0 < 0 ? "at constant acceleration the ball turns before the wall." : "the ball does not move towards the wall."];
  }

  #drawZero() {
    const { zero, four, flow } = this, state = /** @type {State} */ (this.state);
    if (four) drawZeroTime(zero, four, state.sigma, flow ?? []);
    else zero.say(this.#still().join(" "));
  }

  raster() {
    return { samples: SAMPLES, from: this.u[0], impact: Boolean(this.four) };
  }

  summary() {
    const { u, full, local, jumps, four } = this, state = /** @type {State} */ (this.state);
    if (!full || !local || !jumps) return [];
    const said = [{ text: `One period of the forcing from u(0) between ${numeral(u[0])} and ${numeral(u[SAMPLES - 1])}, v(0) = ${numeral(state.v0)}.` }];
    for (const { map, at, below, above, strobe } of jumps) {
      if (map === "orbits") said.push({ text: `The oscillator has ${impacts(below)} below u(0) = ${told(at, state.line)}, and ${below < 0 || above < 0 ? `${impacts(above)} above.` : `${above} above: ${strobe ? "no graze, one comes just at the end of the period" : "there the ball grazes the wall"}.`}` });
      else said.push({ text: `The discontinuity map jumps at u(0) = ${told(at, state.line)}.` });
    }
    if (!jumps.some(({ map, strobe }) => map === "orbits" && !strobe)) said.push({ text: "No graze of the oscillator is on this line; figures 2.1 and 2.2 show one." });
    const differ = Array.from(full.u, (value, i) => Math.abs(value - local.u[i]));
    const most = differ.reduce((best, value, i) => (value > differ[best] ? i : best), 0);
    said.push({ text: `The positions after a period differ most at u(0) = ${numeral(u[most])}, by ${numeral(differ[most])}.` });
    if (four) said.push({ text: `Zero-time map at u(0) = ${numeral(state.u0)}: δ = ${numeral(four.delta)}, acceleration A = ${numeral(four.acceleration)}; ${four.points.map(([U, V], i) => `(U${"₀₁₂₃"[i]}, V${"₀₁₂₃"[i]}) = (${numeral(U)}, ${numeral(V)})`).join(", ")}.` });
    else if (state.u0 < state.sigma) said.push({ text: this.#still().join(" ") });
    else said.push({ text: `From u(0) = ${numeral(state.u0)}: ${this.#still().join(" ").replace("The", "the")}` });
    return said;
  }
}
