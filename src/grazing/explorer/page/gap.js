// @ts-check
/** The gap map: its diagram in μ with the windows of theory, and the cobweb at the chosen μ. */
import { Beside, Cobweb } from "./cobweb.js";
import { periodColour, theme } from "./colours.js";
import { Diagram } from "./diagram.js";
import { DRAWN, found, outwards } from "./jobs.js";
import { words } from "./orbits.js";
import { LONGEST, numeral, told } from "./state.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./state.js").Pair} Pair */
/** @typedef {import("./plot.js").Axes} Axes */
/** @typedef {import("./svg.js").Pen} Pen */
/** @typedef {import("./machine.js").Machine} Machine */
/** @typedef {{N: number, graze: number, doubling: number, collision: number}} Window */

/** Edges of the windows, none outside 0 < lam < 1, l >= 0. @param {Machine} machine @param {number} lam @param {number} l @returns {Window[]} */
export function windows(machine, lam, l) {
  if (!(lam > 0 && lam < 1 && l >= 0)) return [];
  const { table } = machine.call("edges", { periods: LONGEST, lam, l }, ["table"]);
  return Array.from({ length: LONGEST }, (_, n) => ({ N: n + 1, graze: table[3 * n], doubling: table[3 * n + 1], collision: table[3 * n + 2] }));
}

/** Where orbits lie while mu runs over an interval: the trapping interval and the fixed point x < 0. @param {number} lam @param {number} l @param {Pair} span @returns {Pair} */
export function reach(lam, l, [from, to]) {
  let low = Infinity, high = -Infinity;
  for (let i = 0; i <= 64; i++) {
    const mu = from + ((to - from) * i) / 64;
    const ends = mu < 0 ? [lam < 1 ? mu / (1 - lam) : -1, lam < 1 ? mu / (1 - lam) : 0] : [mu - Math.max(l, 0) - Math.sqrt(mu), mu];
    low = Math.min(low, ...ends);
    high = Math.max(high, ...ends);
  }
  const room = 0.05 * (high - low) || 0.1;
  return outwards(low - room, high + room);
}

/** Shade windows and draw their edges; `place` turns an edge in μ into a value on the axis, `name` a period into a word. @param {Axes} axes @param {Pen} c @param {Window[]} all @param {(mu: number) => number} place @param {(N: number) => string} name */
export function drawWindows(axes, c, all, place = (mu) => mu, name = String) {
  const { box } = axes;
  let last = Infinity, before = 0;
  const shown = all
    .filter(({ doubling, collision }) => doubling < collision)
    .map(({ N, doubling, collision }) => ({ N, ends: [place(doubling), place(Number.isFinite(collision) ? collision : 1e9)] }));
  axes.inside(() => {
    for (const { N, ends } of shown) {
      const [a, b] = ends.map((v) => Math.min(Math.max(axes.x(v), box.x - 1), box.x + box.w + 1)).sort((p, q) => p - q);
      if (b - a < 1 || b <= box.x || a >= box.x + box.w) continue;
      const colour = periodColour(N);
      c.fillStyle = colour + "1c";
      c.fillRect(a, box.y, b - a, box.h);
      if (b - a < 4) continue; // edges so near would hide the orbits
      c.lineWidth = 1.1;
      c.strokeStyle = colour;
      for (const [edge, dash] of /** @type {[number, number[]][]} */ ([[ends[0], [5, 3]], [ends[1], []]])) {
        c.setLineDash(dash);
        c.beginPath();
        c.moveTo(axes.x(edge), box.y);
        c.lineTo(axes.x(edge), box.y + box.h);
        c.stroke();
      }
      c.setLineDash([]);
    }
  });
  c.textAlign = "center";
  c.textBaseline = "bottom";
  for (const { N, ends } of shown) {
    const a = Math.max(Math.min(...ends), axes.x0), b = Math.min(Math.max(...ends), axes.x1);
    if (!(b > a)) continue;
    const middle = axes.x((a + b) / 2);
    const wide = c.measureText(name(N)).width / 2, room = Math.abs(last - middle) >= wide + before + 11; // those after the first without room are narrower still
    c.fillStyle = room ? periodColour(N) : theme().faint;
    c.fillText(room ? name(N) : "…", room ? middle : last + (middle < last ? -1 : 1) * (before + 13), box.y - 3);
    if (!room) break;
    [last, before] = [middle, wide];
  }
}

/** Say under the axis, where there is room beside the progress, what is seen. @param {Axes} axes @param {Pen} c @param {number} left of it something else is said */
export function sayBelow({ box }, c, left = 0, text = "bands: windows of theory") {
  c.fillStyle = theme().faint;
  c.textAlign = "left";
  c.textBaseline = "bottom";
  if (left + c.measureText(text).width < box.w / 2 - 20) c.fillText(text, box.x + left, box.y + box.h + 42);
}

/** One step of the map. @param {State} state @param {number} x */
const stepped = ({ lam, mu, l }, x) => (x < 0 ? lam * x + mu : mu - l - Math.sqrt(x));

/** A start and what follows it. @param {State} state */
function walk(state) {
  const found = [state.x0];
  for (let n = 0; n < state.web; n++) found.push(stepped(state, found[n]));
  return found;
}

/** The diagram that a state asks for. @param {State} state @param {number} tolerance @returns {import("./diagram.js").Spec} */
function diagramOf(state, tolerance) {
  const [low, high] = state.range ?? reach(state.lam, state.l, state.span);
  return {
    machine: "gap", row: Float64Array.of(state.lam, state.mu, state.l), which: 1, span: state.span, columns: state.columns, bins: state.bins, low, high, coordinate: 0,
    starts: state.starts, transient: state.transient, keep: state.keep, seed: state.seed, tolerance,
    colour: state.colour, labels: ["μ", "x"], cost: 1, quick: { stride: 1, starts: 4, transient: Math.min(200, state.transient), keep: 112 },
  };
}

export class GapView extends Beside {
  /** @type {Window[]} */ windows = [];
  /** @type {import("./jobs.js").Class[]} */ classes = [];

  /**
   * @param {Machine} machine
   * @param {import("./pool.js").Pool} pool
   * @param {{tolerance: number}} described
   * @param {import("./state.js").Events} events
   */
  constructor(machine, pool, described, { change, problem, done }) {
    super();
    this.machine = machine;
    this.described = described;
    this.tolerance = described.tolerance;
    this.diagram = new Diagram(/** @type {HTMLCanvasElement} */ (document.getElementById("gap-diagram")), pool, "gap", {
      pick: (mu) => change({ mu }),
      zoom: (span, range) => change({ span, range }),
      follows: () => !this.state.range,
      zoomOut: () => change({ span: null, range: null }),
      chosen: () => this.state.mu,
      under: (axes, c) => this.state.theory && drawWindows(axes, c, this.windows),
      overlay: (axes, c) => this.#overlay(axes, c),
      problem,
      done,
    });
    this.cobweb = new Cobweb(this, { change });
  }

  /** The diagram that another state asks for. @param {State} state */
  specOf(state) {
    return diagramOf(state, this.tolerance);
  }

  /** Show a state; the raster is computed again only if it changes. @param {State} state */
  show(state) {
    this.state = state;
    const spec = this.specOf(state), { row } = spec;
    this.windows = windows(this.machine, state.lam, state.l);
    const key = JSON.stringify({ ...spec, row: [state.lam, state.l] });
    if (key !== this.key) {
      this.key = key;
      this.diagram.show(spec);
    } else this.diagram.draw();
    this.classes = found(this.machine, { row, which: 1, value: state.mu, starts: DRAWN, transient: Math.max(2000, state.transient), seed: state.seed, tolerance: this.tolerance });
    for (const each of this.classes) {
      if (each.period > 0) each.multiplier = each.points.reduce((product, [x]) => product * (x < 0 ? state.lam : -0.5 / Math.sqrt(x)), 1);
    }
    this.cobweb.draw();
  }

  /** The cobweb at μ. @returns {import("./cobweb.js").Web} */
  web() {
    const { state } = this, { lam, mu, l } = state, seen = this.classes.flatMap((each) => each.points.map(([x]) => x)).concat(stepped(state, state.x0)).filter(Number.isFinite);
    let low = Math.min(mu - l - Math.sqrt(Math.max(mu, 0)), ...seen, state.x0, -0.02), high = Math.max(mu, ...seen, state.x0, 0.02);
    const room = 0.08 * (high - low);
    low -= room;
    high += room;
    const root = Array.from({ length: 121 }, (_, i) => { const x = high * (i / 120) ** 2; return [x, stepped(state, x)]; });
    return { ends: [[low, high], [low, high]], labels: ["xₙ", "xₙ₊₁"], graph: [[[low, lam * low + mu], [0, mu]], root], cross: 0, walk: walk(state).map((x) => [x]) };
  }

  /** What of theory lies under the diagram of a state. @param {Axes} axes @param {Pen} c @param {State} state */
  backdrop(axes, c, { lam, l }) {
    drawWindows(axes, c, windows(this.machine, lam, l));
  }

  /** @param {Axes} axes @param {Pen} c */
  #overlay(axes, c) {
    if (this.state.theory && this.windows.length) sayBelow(axes, c);
    axes.vertical(0, theme().graze, [2, 2]);
    axes.vertical(this.state.mu, theme().accent, [], 1.6);
  }

  /** What is shown, in words. */
  summary() {
    const { lam, mu, l, span } = this.state;
    /** @type {import("./state.js").Line[]} */
    const said = [{ text: `At μ = ${told(mu, span)}, λ = ${numeral(lam)}, l = ${numeral(l)}:` }];
    said.push(...words(this.classes));
    const own = walk(this.state), letters = own.slice(0, -1).map((x) => (x < 0 ? "L" : "R")).join("");
    if (letters) said.push({ text: `From x₀ = ${numeral(own[0])}: ${letters.length > 60 ? `…${letters.slice(-60)}` : letters}, now x = ${numeral(own[own.length - 1])}.` });
    const inside = this.windows.filter(({ doubling, collision }) => mu > doubling && mu < collision);
    if (!this.windows.length) said.push({ text: "The windows of theory are known for 0 < λ < 1 and l ≥ 0." });
    else if (mu < 0) said.push({ text: "Below the graze, μ < 0: the fixed point x = μ/(1 − λ) is never hit." });
    else if (inside.length) said.push({ text: `Inside ${inside.map(({ N, doubling, collision }) => `Ω${String(N)} (${told(doubling, span)} < μ${Number.isFinite(collision) ? ` < ${told(collision, span)}` : ""})`).join(" and ")}${inside.length > 1 ? ": orbits coexist" : ""}.` });
    else said.push({ text: "Between windows: no maximal orbit is stable here." });
    return said;
  }
}
