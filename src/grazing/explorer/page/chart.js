// @ts-check
/** A chart of two parameters by the period that most starts settle on, or basins over initial states by attractor; coarse at once, then refined, first where boundaries are. */
import { merged, ordered, percent, sameWithin } from "./basins.js";
import { periodColour, rgb, theme } from "./colours.js";
import { plainSymbol } from "./controls.js";
import { rowOf, valueOf } from "./flow.js";
import { Gestures } from "./gestures.js";
import { DRAWN, basins, linspace } from "./jobs.js";
import { SEARCHING, Search, costOf, within, words } from "./orbits.js";
import { Axes } from "./plot.js";
import { allowed, numeral, tidy, told } from "./state.js";
import { ceiling, inside } from "./walls.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./state.js").Pair} Pair */
/** @typedef {import("./machine.js").Machine} Machine */
/**
 * What is computed: `keys` are the parts of the state with the ends of the axes (one of a strip), `names` those that they show.
 * @typedef {{machine: Machine, name: "gap" | "oscillator" | "map", basins: boolean, names: string[], which: number[], row: import("./machine.js").Floats, keys: string[], ends: [Pair, Pair], sizes: Pair, settings: {starts: number, transient: number, keep: number}, cost: number}} Plan
 */

const NONE = -1; // no cell yet
/** Where states of one coordinate lie in the height of their strip. */
const MIDDLE = 0.5;
/** The steps between the cells of a grid, along both axes; each grid holds the one before. */
const STEPS = [8, 4, 2, 1];
/** Steps of the gap map in one job, and milliseconds between pictures, which take the processors from what they show. */
const WORK = 1e6, PAUSE = 100;

export class ChartView {
  /** @type {import("./jobs.js").Reached[]} */ reached = [];
  /** @type {string | undefined} what is computed, undefined for nothing */ key = undefined;
  #asked = 0;

  /** What is charted, but for its ends, as text. */ #same = "";
  /** The ends of what is on screen. @type {[Pair, Pair] | undefined} */ #seen = undefined;

  /**
   * @param {Record<string, Machine>} machines
   * @param {import("./pool.js").Pool} pool
   * @param {{tolerance: number}} described
   * @param {import("./state.js").Events} events
   */
  constructor(machines, pool, described, { change, problem, done }) {
    this.machines = machines;
    this.pool = pool;
    this.problem = problem;
    this.done = done;
    this.tolerance = described.tolerance;
    this.axes = new Axes(document.getElementById("chart"));
    this.search = new Search(pool, "chart-words", { found: done, problem });
    this.image = document.createElement("canvas");
    this.gestures = new Gestures(this.axes, {
      ready: () => Boolean(this.plan),
      redraw: () => this.#draw(),
      pick: (x, y) => change(this.#picked(x, y)),
      zoom: (...ends) => this.plan && change(Object.fromEntries(this.plan.keys.map((key, i) => [key, this.#allowed(/** @type {Pair} */ (ends[i]), i)]))),
      zoomOut: () => this.plan && change(Object.fromEntries(this.plan.keys.map((key) => [key, null]))),
      chosen: () => this.#chosen(),
      steps: () => /** @type {Pair} */ ((this.plan?.sizes ?? [101, 101]).map((size) => size - 1)),
    });
  }

  get canvas() {
    return this.axes.canvas;
  }

  /** @returns {import("./svg.js").Panel[]} */
  panels() {
    return [{ sheet: this.axes, draw: () => this.#draw() }];
  }

  /** The part of an interval that the kernels accept. @param {Pair} ends @param {number} i @returns {Pair} */
  #allowed([low, high], i) {
    const { plan, state } = this;
    if (!plan || !state) return [low, high];
    if (plan.basins && plan.name === "map") return [low, high];
    if (plan.basins) return i === 0 ? [inside(state, low, state.phase), Number.isFinite(ceiling(state)) ? inside(state, high, state.phase) : high] : [low, high];
    return allowed(plan.machine.described.fields[plan.which[i]], [low, high]);
  }

  /** What a click chooses. @param {number} x @param {number} y */
  #picked(x, y) {
    const { plan, state } = this;
    if (!plan || !state) return {};
    const [a, b] = [x, y].map((value, i) => tidy(value, plan.ends[i][1] - plan.ends[i][0]));
    if (plan.basins && plan.name === "map") return plan.names.length > 1 ? { x0: a, y0: b } : { x0: a };
    return plan.basins ? { ball: [inside(state, a, state.phase), b, state.phase] } : { [plan.names[0]]: a, [plan.names[1]]: b };
  }

  /** @returns {Pair} */
  #chosen() {
    const { plan, state } = this;
    if (!plan || !state) return [NaN, NaN];
    if (!plan.basins) return /** @type {Pair} */ (plan.names.map((name) => valueOf(state, name)));
    const [low, high] = plan.ends;
    if (plan.name === "map") return [state.x0, plan.names.length > 1 ? state.y0 : MIDDLE];
    return state.ball ? [state.ball[0], state.ball[1]] : [(low[0] + low[1]) / 2, (high[0] + high[1]) / 2];
  }

  /** @param {State} state @returns {Plan} */
  #planOf(state) {
    const gap = state.chart === "gap", name = gap ? "gap" : state.chart.startsWith("map") ? "map" : "oscillator";
    const machine = this.machines[name];
    if (!machine) throw new Error(`the module ${name}.wasm is not loaded`);
    const sizes = /** @type {Pair} */ ([state.chart_columns, state.chart_rows]);
    const row = gap ? Float64Array.of(state.lam, state.mu, state.l) : rowOf(machine, state);
    if (state.chart === "map-basins") {
      const names = machine.described.coordinates, strip = names.length === 1;
      return {
        machine, name, basins: true, names, which: [], row, keys: ["positions", "velocities"].slice(0, names.length), ends: [state.positions, strip ? [0, 1] : state.velocities],
        sizes: strip ? [sizes[0], 1] : sizes, settings: { starts: 1, transient: 500, keep: 64 }, cost: 2,
      };
    }
    if (state.chart === "basins") {
      const [from, to] = state.positions, [low, high] = [from, to].map((end) => inside(state, end, state.phase));
      if (high <= low) throw new Error(`positions run ${low > to ? `to ${to}, behind the wall at ${low}; choose some above` : `from ${from}, behind the wall at ${high}; choose some below`} it`);
      return {
        machine, name, basins: true, names: ["u", "v"], which: [], row, keys: ["positions", "velocities"],
        ends: [[low, high], state.velocities], sizes, settings: { starts: 1, transient: 300, keep: 64 }, cost: 40 * costOf(state),
      };
    }
    const names = gap ? ["mu", "l"] : [state.vary, state.second];
    if (names[0] === names[1]) throw new Error("both axes show the same parameter; choose another one for the second axis");
    const common = { machine, basins: false, names, which: names.map((name) => machine.fields.indexOf(name)), row, sizes };
    if (name === "map") return { ...common, name, keys: ["reach", "heights"], ends: [state.reach, state.heights], settings: { starts: 8, transient: 500, keep: 64 }, cost: 2 };
    return gap
      ? { ...common, name: "gap", keys: ["span", "gaps"], ends: [state.span, state.gaps], settings: { starts: 8, transient: 500, keep: 64 }, cost: 1 }
      : { ...common, name: "oscillator", keys: ["reach", "heights"], ends: [state.reach, state.heights], settings: { starts: 4, transient: 100, keep: 64 }, cost: 40 * costOf(state) };
  }

  /** @param {State} state */
  show(state) {
    this.state = state;
    const plan = this.#planOf(state);
    const fixed = Array.from(plan.row);
    plan.which.forEach((i) => (fixed[i] = 0));
    const same = JSON.stringify([fixed, plan.names]), key = JSON.stringify([fixed, plan.names, plan.ends, plan.sizes, plan.settings, state.seed]);
    this.plan = plan;
    this.canvas.classList.toggle("strip", plan.keys.length === 1);
    if (this.key === undefined) this.search.forget();
    if (key !== this.key) {
      this.key = key;
      /** Of each cell the period, 0 without one; in basins the row of `reached`. */
      this.codes = new Int16Array(plan.sizes[0] * plan.sizes[1]).fill(NONE);
      this.reached = [];
      if (same !== this.#same) this.#seen = undefined;
      this.#same = same;
      this.canvas.dataset.stage = "computing";
      this.#begun = performance.now();
      this.#compute(plan, this.codes).catch((error) => {
        this.canvas.dataset.stage = "failed";
        this.problem(`The chart could not be computed: ${error.message}.`);
      });
    }
    if (!plan.basins) {
      const gap = plan.name !== "oscillator", which = plan.which[0]; // a step that is short
      const T = gap ? 1 : (2 * Math.PI) / state.omega;
      this.search.ask(plan.name, plan.machine, { row: plan.row, which, value: plan.row[which], starts: gap ? DRAWN : 16, transient: gap ? 2000 : within(300, T), keep: gap ? 128 : within(64, T), seed: state.seed, tolerance: this.tolerance }, gap ? 0.01 : costOf(state));
    }
    this.paint();
  }

  /** @param {Plan} plan @param {Int16Array} codes */
  async #compute(plan, codes) {
    const batch = this.pool.batch("chart");
    const [xs, ys] = plan.sizes.map((size, i) => linspace(...plan.ends[i], size));
    const { reached } = this, seed = this.state?.seed ?? 0;
    const same = plan.basins ? sameWithin(plan.ends.slice(0, plan.names.length), plan.machine.call("boxes", { columns: 1, rows: plan.row }, ["boxes"]).boxes) : new Float64Array(2);
    const given = { row: plan.row, which: plan.which, ...plan.settings, seed, tolerance: this.tolerance };
    const reach = async (/** @type {import("./machine.js").Floats} */ values) => {
      const { which, reached: some } = await batch.run(plan.name, "basins", { ...given, values, same });
      const known = merged(reached, some, same);
      return which.map((k) => known[k]);
    };
    const size = Math.max(1, Math.round(WORK / (plan.settings.starts * (plan.settings.transient + 64) * plan.cost)));
    /** Compute cells, whose numbers are given. @param {number[]} cells */
    const compute = (cells) => Promise.all(Array.from({ length: Math.ceil(cells.length / size) }, async (_, n) => {
      const some = cells.slice(n * size, (n + 1) * size), values = Float64Array.from(some.flatMap((cell) => [xs[cell % W], ys[Math.floor(cell / W)]].slice(0, plan.names.length)));
      const made = await (plan.basins ? reach(values) : batch.run(plan.name, "chart", { ...given, values }).then((found) => found.codes));
      some.forEach((cell, k) => (codes[cell] = made[k]));
      this.#asked ||= window.setTimeout(() => this.paint(), PAUSE);
    }));
    const W = xs.length, all = Array.from(codes.keys());
    for (const edges of [true, false]) {
      for (const step of STEPS) {
        const filled = this.#filled(), wide = 2 * step;
        /** Whether a cell lies between cells that differ. @param {number} i @param {number} j */
        const between = (i, j) => {
          const a = i - (i % wide), b = j - (j % wide), right = Math.min(a + wide, W - 1), up = Math.min(b + wide, ys.length - 1), code = filled[b * W + a];
          return step === STEPS[0] || [b * W + right, up * W + a, up * W + right].some((cell) => filled[cell] !== code);
        };
        await compute(all.filter((cell) => {
          const i = cell % W, j = Math.floor(cell / W);
          return codes[cell] === NONE && i % step === 0 && j % step === 0 && (!edges || between(i, j));
        }));
        if (!batch.live()) return;
        if (!edges && step === 1) this.canvas.dataset.stage = "done";
        this.paint();
        if (edges || step === 1) this.done(); // until the last time shares are estimates
      }
    }
  }

  /** The picture as far as it is known: of a cell that is not, the code of the nearest coarser one. */
  #filled() {
    const codes = /** @type {Int16Array} */ (this.codes), W = this.plan?.sizes[0] ?? 1;
    return codes.map((code, cell) => {
      const i = cell % W, j = Math.floor(cell / W);
      for (let n = STEPS.length - 2; n >= 0 && code === NONE; n--) code = codes[(j - (j % STEPS[n])) * W + i - (i % STEPS[n])];
      return code;
    });
  }

  /** When the picture was begun. */ #begun = 0;

  repaint() {
    if (this.plan) this.paint();
  }

  /** The attractors of the basins that are known, the largest basin first. */
  attractors() {
    const cells = new Array(this.reached.length).fill(0);
    for (const code of this.codes ? this.#filled() : []) if (code !== NONE) cells[code]++;
    return ordered(this.reached, cells);
  }

  /** The colour of each code that occurs. @returns {Map<number, string>} */
  #colours() {
    if (this.plan?.basins) return new Map(this.attractors().map(({ row, colour }) => [row, colour]));
    const codes = [...new Set(this.codes)].filter((code) => code !== NONE).sort((a, b) => a - b);
    return new Map(codes.map((code) => [code, code ? periodColour(code) : theme().chaos]));
  }

  /** Make the raster again, and draw it. */
  paint() {
    clearTimeout(this.#asked);
    this.#asked = 0;
    const { plan, codes } = this;
    if (!plan || !codes) return;
    const [W, H] = plan.sizes, known = codes[0] !== NONE;
    if (!known && this.#seen) return this.#draw(); // nothing is known yet: the picture before moves with the hand
    if (known) this.#seen = plan.ends;
    this.colours = this.#colours();
    const shades = new Map([...this.colours].map(([code, colour]) => [code, rgb(colour)]));
    this.image.width = W;
    this.image.height = H;
    const c = this.image.getContext("2d");
    const pixels = c?.createImageData(W, H), filled = this.#filled();
    for (let j = 0; pixels && j < H; j++) {
      for (let i = 0; i < W; i++) {
        const tone = shades.get(filled[j * W + i]), at = ((H - 1 - j) * W + i) * 4;
        if (!tone) continue;
        pixels.data[at] = tone[0];
        pixels.data[at + 1] = tone[1];
        pixels.data[at + 2] = tone[2];
        pixels.data[at + 3] = 255;
      }
    }
    if (c && pixels) c.putImageData(pixels, 0, 0);
    this.#draw();
  }

  #draw() {
    const { axes, plan } = this;
    if (!plan) return;
    const c = axes.begin();
    axes.span(...plan.ends[0], ...plan.ends[1]);
    axes.inside(() => {
      c.imageSmoothingEnabled = false;
      const [[left, right], [bottom, top]] = this.#seen ?? plan.ends, [x, y] = [axes.x(left), axes.y(top)];
      c.drawImage(this.image, x, y, axes.x(right) - x, axes.y(bottom) - y);
      if (plan.basins) for (const { point, colour } of this.attractors()) if (point.length) this.#dot(c, point, colour);
      const at = this.#chosen();
      if (!plan.basins || plan.name === "map" || this.state?.ball) this.#ring(c, axes.x(at[0]), axes.y(at[1]));
    });
    const symbols = this.#symbols();
    axes.frame(symbols[0], symbols[1] ?? "");
    this.#legend(c);
    if (this.canvas.dataset.stage === "computing") axes.progress(this.codes ? 1 - this.codes.filter((code) => code === NONE).length / this.codes.length : 0, this.#begun);
    this.gestures.draw(c);
  }

  /** @param {import("./svg.js").Pen} c @param {number[]} point @param {string} colour */
  #dot(c, [u, v = MIDDLE], colour) {
    for (const [radius, fill] of /** @type {[number, string][]} */ ([[5.5, "#1a1a1a"], [4.5, "#ffffff"], [3, colour]])) {
      c.fillStyle = fill;
      c.beginPath();
      c.arc(this.axes.x(u), this.axes.y(v), radius, 0, 2 * Math.PI);
      c.fill();
    }
  }

  /** @param {import("./svg.js").Pen} c @param {number} x @param {number} y */
  #ring(c, x, y) {
    for (const [colour, width] of /** @type {[string, number][]} */ ([["#ffffff", 4], ["#000000", 1.6]])) {
      c.strokeStyle = colour;
      c.lineWidth = width;
      c.beginPath();
      c.arc(x, y, 7, 0, 2 * Math.PI);
      c.stroke();
    }
  }

  /** The colours that occur, as many as there is room for. @param {import("./svg.js").Pen} c */
  #legend(c) {
    const { axes, plan } = this;
    const share = (/** @type {{share: number}} */ each) => (this.canvas.dataset.stage === "done" ? `: ${percent(each.share)}` : ""); // the words say what it is so far
    let named = plan?.basins
      ? this.#shares().map((each) => ({ ...each, text: called(each, plan.name === "map") + share(each), word: each.word && each.word + share(each) }))
      : [...(this.colours ?? [])].map(([code, colour]) => ({ colour, word: "", text: code ? String(code) : "none" }));
    if (named.reduce((sum, { text }) => sum + c.measureText(text).width + 29, -14) > axes.box.w) named = named.map((each) => ({ ...each, text: each.word || each.text }));
    c.textAlign = "left";
    c.textBaseline = "middle";
    let x = axes.box.x;
    const end = axes.box.x + axes.box.w;
    for (const [i, { colour, text }] of named.entries()) {
      const wide = c.measureText(text).width, left = named.length - i, more = `and ${left} more`;
      if (x + 15 + wide + (left > 1 ? 14 + c.measureText(more).width : 0) > end) {
        c.fillStyle = theme().faint;
        c.fillText(more, x, 11);
        break;
      }
      c.fillStyle = colour;
      c.fillRect(x, 5, 11, 11);
      c.fillStyle = theme().faint;
      c.fillText(text, x + 15, 11);
      x += 15 + wide + 14;
    }
  }

  /** The attractors, each with its share of the picture. */
  #shares() {
    const all = this.attractors(), cells = all.reduce((total, each) => total + each.cells, 0);
    return all.map((each) => ({ ...each, share: each.cells / cells }));
  }

  #symbols() {
    const { names, machine, basins } = /** @type {Plan} */ (this.plan);
    return basins ? names : names.map((each) => plainSymbol(machine.described.fields[machine.fields.indexOf(each)]));
  }

  raster() {
    const { settings, ends, sizes, names, name, basins } = /** @type {Plan} */ (this.plan);
    return { ...settings, ends, sizes, names, name, basins };
  }

  /** What is shown, in words. @returns {{colour?: string, text: string}[]} */
  summary() {
    const { plan, state } = this;
    if (!plan || !state) return [];
    if (plan.basins) return this.#inWords(state);
    const symbols = this.#symbols();
    const at = symbols.map((symbol, i) => `${symbol} = ${told(valueOf(state, plan.names[i]), plan.ends[i])}`).join(", ");
    return [{ text: `At ${at}:` }, ...(this.search.waiting ? [{ text: SEARCHING }] : []), ...words(this.search.classes), ...this.#periods()];
  }

  /** The periods that occur, all of them, and which of them share a colour. @returns {import("./state.js").Line[]} */
  #periods() {
    const periods = [...(this.colours ?? [])].map(([code]) => code).filter(Boolean);
    if (!periods.length) return [];
    const alike = periods.map((one) => periods.filter((other) => periodColour(other) === periodColour(one)));
    const shared = [...new Set(alike.filter((some) => some.length > 1).map((some) => some.join(" and ")))];
    return [{ text: `Periods in the picture${this.canvas.dataset.stage === "done" ? "" : " so far"}: ${periods.join(", ")}${periods.includes(254) ? " or above" : ""}.${shared.length ? ` One colour stands for ${shared.join(", for ")}.` : ""}` }];
  }

  /** The basins in words: what the chosen state reaches, and each attractor with its share of the picture. @param {State} state */
  #inWords(state) {
    const plan = /** @type {Plan} */ (this.plan);
    const all = this.#shares();
    /** @type {import("./state.js").Line[]} */
    const said = [];
    if (plan.name === "map") {
      const [x, y] = this.#chosen(), at = [x, y].slice(0, plan.names.length), { reached } = this.#follow(at);
      said.push({ text: `From ${this.#states(at.map((each) => numeral(each)))} an orbit reaches: ${called(reached[0], true)}.` });
    } else if (state.ball) {
      const [u, v] = state.ball;
      const free = inside(state, u, state.ball[2]);
      if (free !== u) said.push({ text: `(${numeral(u)}, ${numeral(v)}) lies behind the wall at ${numeral(free)}.` });
      const { reached } = free !== u ? { reached: [] } : this.#follow([u, v]);
      if (reached.length) said.push({ text: `From (${numeral(u)}, ${numeral(v)}) the ball reaches: ${called(reached[0])}. “Ball” throws it from there.` });
    }
    said.push({ text: `Initial states ${this.#states(plan.names)}${plan.name === "map" ? "" : " at the strobe"} with ${plan.names.map((name, i) => plan.ends[i].map((end) => numeral(end)).join(` ≤ ${name} ≤ `)).join(" and ")}, by the attractor that they reach${this.canvas.dataset.stage === "computing" ? ", so far" : ""}:` });
    for (const each of all.slice(0, 12)) {
      const place = each.point.length ? `; a point of it: ${this.#states(each.point.map((each) => numeral(each)))}` : "";
      said.push({ colour: each.colour, text: `${called(each, plan.name === "map")}: ${percent(each.share)} of the picture`, exact: place });
    }
    if (all.length > 12) said.push({ text: `${all.length - 12} more: ${percent(all.slice(12).reduce((sum, each) => sum + each.share, 0))} of the picture` });
    return said;
  }

  /** A state in words. @param {string[]} numbers */
  #states = (numbers) => (numbers.length > 1 ? `(${numbers.join(", ")})` : numbers[0]);

  /** @param {number[]} start */
  #follow(start) {
    const plan = /** @type {Plan} */ (this.plan), T = plan.name === "map" ? 1 : (2 * Math.PI) / (this.state?.omega ?? 1);
    return basins(plan.machine, { row: plan.row, values: Float64Array.from(start), transient: within(plan.settings.transient, T), keep: within(plan.settings.keep, T), tolerance: this.tolerance, same: new Float64Array(start.length) });
  }
}

/** What an attractor is called; `bare` for a map that may give its steps no letters. @param {import("./jobs.js").Reached} each */
function called({ period, word }, bare = false) {
  if (period < 1) return { "-1": "aperiodic as far as seen", 0: "undecided", "-2": "ended" }[period] ?? `class ${period}`;
  return `period ${period}${bare && word === "0" ? "" : `, word ${word}`}`;
}
