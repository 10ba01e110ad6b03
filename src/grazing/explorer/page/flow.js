// @ts-check
/** The orbit diagram of the oscillator in any of its parameters, and the reduced one below it. */
import { theme } from "./colours.js";
import { Diagram } from "./diagram.js";
import { drawWindows, reach, sayBelow, windows } from "./gap.js";
import { linspace, normalForm } from "./jobs.js";
import { ownOf } from "./laws.js";
import { SEARCHING, Search, costOf, drawnFrom, within, words } from "./orbits.js";
import { plainSymbol } from "./controls.js";
import { allowed, later, numeral, told } from "./state.js";
import { isPinball } from "./text.js";
import { crossings, still } from "./walls.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./machine.js").Machine} Machine */
/** @typedef {import("./machine.js").Floats} Floats */
/** @typedef {import("./plot.js").Axes} Axes */
/** @typedef {import("./svg.js").Pen} Pen */

/** A period of the forcing longer than this is long: the ball's view has no diagram. */
const SLOW = 60;
/** Where walls are hit more often in a period than this, the first picture is of fewer orbits, and of a handful. */
const OFTEN = 4, ENDLESSLY = 80;

/** The value of a parameter of the oscillator. @param {State} state @param {string} name */
export const valueOf = (state, name) => /** @type {Record<string, any>} */ (state)[name];

/** The row of parameters of a state, in the order of the module's fields. @param {Machine} machine @param {State} state @returns {Floats} */
export function rowOf(machine, state) {
  return Float64Array.from(machine.described.fields, ({ name, choices }) => {
    if (name === "order") return 0;
    if (name === "paper") return Number(isPinball(state));
    if (name === "two") return Number(state.two);
    return choices ? choices.indexOf(valueOf(state, name)) : valueOf(state, name);
  });
}

/**
 * How much is computed for a diagram, and for its first picture, and what a step costs.
 * @typedef {{machine: string, starts: number, transient: number, keep: number, cost: number, quick: import("./diagram.js").Spec["quick"]}} Work
 */

/** The work for a diagram of the oscillator. @param {State} state @returns {Work & {slow: boolean}} */
function workOf(state) {
  const ends = state.reach.map((end) => ({ ...state, [state.vary]: end })), cost = Math.max(...ends.map(costOf));
  const hits = Math.max(...ends.map(crossings)), dear = hits > OFTEN;
  const slow = (2 * Math.PI) / Math.min(...ends.map(({ omega }) => omega)) > SLOW || hits > ENDLESSLY;
  return {
    machine: "oscillator", starts: state.flow_starts, transient: state.flow_transient, keep: state.flow_keep, cost: 40 * cost, slow,
    quick: hits > ENDLESSLY ? { stride: 100, starts: 1, transient: 8, keep: 8 } : dear ? { stride: 24, starts: 2, transient: 30, keep: 30 } : { stride: 16, starts: 4, transient: 50, keep: 40 },
  };
}

/**
 * The diagram that a state asks for: the key of all that it depends on, and what it shows.
 * @param {Machine} machine @param {State} state @param {number} tolerance @param {Work} work
 */
export function planned(machine, state, tolerance, { machine: name, starts, transient, keep, cost, quick }) {
  const row = rowOf(machine, state), which = machine.fields.indexOf(state.vary);
  const coordinate = machine.described.coordinates.indexOf(state.coordinate);
  const common = { span: state.reach, columns: state.columns, starts, transient, keep, seed: state.seed, tolerance, colour: state.colour };
  const others = Array.from(row);
  others[which] = 0;
  const key = JSON.stringify({ ...common, others, which, coordinate, window: state.window, bins: state.bins });
  const [low, high] = state.window ?? [NaN, NaN], symbol = plainSymbol(machine.described.fields[which]);
  /** @type {import("./diagram.js").Spec} */
  const spec = { ...common, machine: name, row, which, coordinate, low, high, bins: state.bins, labels: [symbol, state.coordinate], cost, quick: { ...quick, stride: Math.ceil(quick.stride * Math.min(1, state.columns / 400)) } };
  return { row, which, common, key, spec };
}

/** The diagram of the oscillator that a state asks for. @param {Machine} machine @param {State} state @param {number} tolerance */
export function diagramOf(machine, state, tolerance) {
  const work = workOf(state);
  return { ...planned(machine, state, tolerance, work), slow: work.slow };
}

/** What a diagram over any parameter answers to. @param {{state: State}} view @param {Machine} machine @param {Pick<import("./state.js").Events, "change" | "problem" | "done">} told */
export function events(view, machine, { change, problem, done }) {
  const field = () => machine.described.fields[machine.fields.indexOf(view.state.vary)];
  return {
    pick: (/** @type {number} */ value) => change({ [view.state.vary]: value }),
    zoom: (/** @type {number[]} */ span, /** @type {number[] | null} */ window) => change({ reach: allowed(field(), /** @type {import("./state.js").Pair} */ (span)), window }),
    follows: () => !view.state.window,
    zoomOut: () => change({ reach: null, window: null }),
    chosen: () => valueOf(view.state, view.state.vary),
    problem,
    done,
  };
}

export class FlowView {
  /** @type {State} */ state = later();
  /** @type {import("./gap.js").Window[]} */ windows = [];
  /** @type {ReturnType<typeof normalForm>} */ form = null;
  /** Why there is no reduced diagram, if there is none. */ why = "";
  /** The columns of the reduced diagram: values of the parameter, and of μ. */
  values = new Float64Array(0);
  mu = new Float64Array(0);
  /** @type {string | undefined} what is computed, undefined for nothing */ key = undefined;

  /**
   * @param {Machine} machine
   * @param {Machine | undefined} gap
   * @param {import("./pool.js").Pool} pool
   * @param {{tolerance: number}} described
   * @param {import("./state.js").Events} told
   */
  constructor(machine, gap, pool, described, { change, problem, done }) {
    this.machine = machine;
    this.gap = gap;
    this.tolerance = described.tolerance;
    const answers = events(this, machine, { change, problem, done });
    this.diagram = new Diagram(/** @type {HTMLCanvasElement} */ (document.getElementById("flow-diagram")), pool, "flow", { ...answers, ranged: done, overlay: (axes, c) => this.#overlay(axes, c), under: (axes, c) => this.#under(axes, c) });
    this.reduced = new Diagram(/** @type {HTMLCanvasElement} */ (document.getElementById("reduced-diagram")), pool, "reduced", {
      ...answers, done: undefined, follows: () => true, zoom: (span) => answers.zoom(span, this.state.window), overlay: (axes, c) => this.#overlay(axes, c, true), under: (axes, c) => this.#under(axes, c),
    });
    this.search = new Search(pool, "flow-words", { found: done, problem });
    this.figure = /** @type {HTMLElement} */ (document.getElementById("reduced-figure"));
  }

  get canvas() {
    return this.diagram.axes.canvas;
  }

  /** @returns {import("./svg.js").Panel[]} */
  panels() {
    return [this.diagram, this.reduced].map((each) => ({ sheet: each.axes, draw: () => each.draw() }));
  }

  /** @param {State} state */
  show(state) {
    this.state = state;
    const { machine } = this;
    const { row, which, common, key: whole, spec } = diagramOf(machine, state, this.tolerance);
    const key = JSON.stringify([whole, state.starts, state.transient, state.keep, state.reduced]);
    if (this.key === undefined) this.search.forget();
    if (key !== this.key) {
      this.key = key;
      this.#reduce(state, row, which, machine.described.fields[which], common); // what lies under the diagram
      this.diagram.show(spec);
    } else {
      this.diagram.draw();
      this.reduced.draw();
    }
    const T = (2 * Math.PI) / state.omega, transient = Math.max(within(300, T), state.flow_transient);
    this.search.ask("oscillator", machine, { row, which, value: valueOf(state, state.vary), transient, keep: within(64, T), seed: state.seed, tolerance: this.tolerance }, costOf(state));
  }

  get classes() {
    return this.search.classes;
  }

  /** The diagram that another state asks for. @param {State} state */
  specOf(state) {
    return diagramOf(this.machine, state, this.tolerance).spec;
  }

  /**
   * Compute the normal form, and its map at the μ of each column.
   * @param {State} state @param {Floats} row @param {number} which @param {import("./machine.js").Field} field
   * @param {Pick<import("./diagram.js").Spec, "span" | "columns" | "starts" | "transient" | "keep" | "seed" | "tolerance" | "colour">} common
   */
  #reduce(state, row, which, field, common) {
    const own = ownOf(state);
    this.form = still(state) && !own ? normalForm(this.machine, row, which, field) : null;
    this.why = this.form ? "" : own ? `Of a law of your own, as ${own.law} is, gz.normal_form gives the normal form, in Python alone.` : !still(state) ? "The normal form is that of one wall at rest." : "No graze of the steady response is near: there is no normal form in this parameter.";
    this.windows = [];
    /** @type {import("./diagram.js").Spec | null} */
    let spec = null;
    if (this.form && this.gap) {
      const { lam, l } = this.form;
      const values = linspace(...state.reach, state.columns);
      const mu = this.form.mu(values);
      if (!mu.every(Number.isFinite)) this.why = "The steady response does not exist on all of this range.";
      else if (!(lam > -1 && lam < 1)) this.why = `λ = ${numeral(lam)} lies outside the form.`;
      else {
        this.mu = mu;
        this.values = values;
        this.windows = windows(this.gap, lam, l);
        const [low, high] = reach(lam, l, [Math.min(...mu), Math.max(...mu)]);
        spec = { ...common, starts: state.starts, transient: state.transient, keep: state.keep, machine: "gap", values: mu, row: Float64Array.of(lam, 0, l), which: 1, coordinate: 0, low, high, bins: state.bins, labels: [plainSymbol(field), "x"], cost: 1, quick: { stride: 1, starts: 4, transient: 200, keep: 112 } };
      }
    } else if (!this.gap) this.why = "The module of the gap map is missing: no reduced diagram.";
    if (!state.reduced) spec = null;
    this.figure.hidden = !spec;
    if (spec) this.reduced.show(spec);
  }

  /** The parameter value at a μ, by the table of columns. @param {number} mu */
  #place = (mu) => {
    for (let i = 1; i < this.mu.length; i++) {
      const a = this.mu[i - 1], b = this.mu[i];
      if ((mu - a) * (mu - b) <= 0 && a !== b) return this.values[i - 1] + ((mu - a) / (b - a)) * (this.values[i] - this.values[i - 1]);
    }
    // beyond the table: the end where μ is nearest
    const first = this.mu[0], last = this.mu[this.mu.length - 1];
    return Math.abs(mu - first) < Math.abs(mu - last) ? this.values[0] - 1e9 : this.values[this.values.length - 1] + 1e9;
  };

  /** @param {Axes} axes @param {Pen} c */
  #under(axes, c) {
    if (this.state.theory && this.windows.length && !this.why) drawWindows(axes, c, this.windows, this.#place, (N) => `${"0".repeat(N - 1)}1`);
  }

  /** @param {Axes} axes @param {Pen} c */
  #overlay(axes, c, reduced = false) {
    if (this.form) axes.vertical(this.form.graze, theme().graze, [2, 2]);
    axes.vertical(valueOf(this.state, this.state.vary), theme().accent, [], 1.6);
    const name = reduced ? "reduced map (2.6)" : "full oscillator"; // below the axis, where no curve is
    sayBelow(axes, c, 0, name);
    if (this.state.theory && this.windows.length && !this.why) sayBelow(axes, c, c.measureText(`${name}  `).width);
  }

  repaint() {
    this.diagram.paint();
    this.reduced.paint();
  }

  raster() {
    return this.diagram.spec;
  }

  summary() {
    const { state } = this;
    const name = plainSymbol(this.machine.described.fields[this.machine.fields.indexOf(state.vary)]);
    const value = valueOf(state, state.vary), { reach: ends } = state;
    /** @type {import("./state.js").Line[]} */
    const said = [{ text: `At ${name} = ${told(value, ends)}:` }];
    if (this.search.waiting) said.push({ text: SEARCHING });
    said.push(...words(this.classes), drawnFrom(this.machine, rowOf(this.machine, state)));
    if (this.form) {
      const { graze, lam, l } = this.form;
      const mu = this.form.mu(Float64Array.of(value))[0];
      said.push({ text: `Normal form at the graze ${name} = ${told(graze, ends)}: λ = ${numeral(lam)}, l = ${numeral(l)}, and here μ = ${numeral(mu)}.` });
      const inside = this.windows.filter(({ doubling, collision }) => mu > doubling && mu < collision);
      if (inside.length && !this.why) said.push({ text: `It predicts ${inside.map(({ N }) => `period ${N}`).join(" and ")} here.` });
    }
    if (this.why) said.push({ text: this.why });
    return said;
  }
}
