// @ts-check
/** A map of the user's own: its diagram in any of its parameters, and the cobweb or the plane of its orbits. */
import { Beside, Cobweb } from "./cobweb.js";
import { theme } from "./colours.js";
import { plainSymbol } from "./controls.js";
import { Diagram } from "./diagram.js";
import { events, planned, valueOf } from "./flow.js";
import { DRAWN, linspace } from "./jobs.js";
import { BROUGHT } from "./laws.js";
import { SEARCHING, Search, words } from "./orbits.js";
import { numeral } from "./state.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./machine.js").Machine} Machine */
/** @typedef {import("./machine.js").Floats} Floats */

/** Places at which a graph is computed at first, halvings of those between which it jumps, and a jump as a share of the picture. */
const PLACES = 400, HALVINGS = 16, JUMP = 0.01, MOST = 4000;
/** A share of the box in which orbits would be small. */
const SMALL = 0.25;

/** The work for a diagram of a map. @param {State} state @returns {import("./flow.js").Work} */
const workOf = ({ starts, transient, keep }) => ({
  machine: "map", starts, transient, keep, cost: 2, quick: { stride: 2, starts: 4, transient: Math.min(200, transient), keep: 56 },
});

/** Take steps from states, one behind the other or all at once. @param {Machine} machine @param {Floats} rows @param {Floats} lanes @param {number} starts @param {number} keep */
const steps = (machine, rows, lanes, starts, keep) => machine.call("orbits", { columns: 1, starts, keep, rows, lanes, transient: 0 }, ["points", "letters"]);

/** The graph of a map of one coordinate, in pieces: more places are put where it jumps, and what still does is two pieces. @param {Machine} machine @param {Floats} row @param {import("./state.js").Pair} ends */
function graphOf(machine, row, [low, high]) {
  const images = (/** @type {Floats} */ xs) => {
    const { points, letters } = steps(machine, row, xs, xs.length, 1);
    return Array.from(xs, (x, i) => ({ x, y: points[i], letter: letters[i] }));
  };
  let found = images(linspace(low, high, PLACES));
  const apart = (/** @type {number} */ i) => {
    const a = found[i], b = found[i + 1];
    return a.letter !== b.letter || !(Math.abs(a.y - b.y) <= JUMP * (high - low));
  };
  for (let n = 0; n < HALVINGS && found.length < MOST; n++) {
    const between = Float64Array.from([...found.keys()].slice(1).map((i) => i - 1).filter(apart), (i) => (found[i].x + found[i + 1].x) / 2);
    if (!between.length) break;
    found = [...found, ...images(between)].sort((a, b) => a.x - b.x);
  }
  /** @type {number[][][]} */
  const pieces = [[]];
  found.forEach(({ x, y }, i) => {
    if (Number.isFinite(y)) pieces[pieces.length - 1].push([x, y]);
    if (i + 1 < found.length && apart(i)) pieces.push([]);
  });
  return pieces.filter((piece) => piece.length);
}

export class MapView extends Beside {
  #graph = /** @type {number[][][]} */ ([]);
  #drawn = "";
  /** @type {Floats} */ #row = new Float64Array(0);

  /**
   * @param {Machine} machine
   * @param {import("./pool.js").Pool} pool
   * @param {{tolerance: number}} described
   * @param {import("./state.js").Events} told
   */
  constructor(machine, pool, described, { change, problem, done }) {
    super();
    this.machine = machine;
    this.tolerance = described.tolerance;
    this.flat = machine.described.coordinates.length > 1;
    const name = BROUGHT.model?.name, [diagram, plane] = ["gap-diagram", "cobweb"].map((id) => /** @type {HTMLCanvasElement} */ (document.getElementById(id)));
    diagram.setAttribute("aria-label", `Diagram of the map ${name}. Arrow keys choose the parameter, plus and minus zoom, 0 shows all.`);
    plane.setAttribute("aria-label", `${this.flat ? "Orbits" : "Cobweb"} of the map ${name}. Arrow keys move the start, S steps, Backspace steps back, 0 begins again.`);
    this.diagram = new Diagram(diagram, pool, "map", { ...events(this, machine, { change, problem, done }), ranged: done, overlay: (axes) => axes.vertical(valueOf(this.state, this.state.vary), theme().accent, [], 1.6) });
    this.search = new Search(pool, "map-words", { found: () => (this.cobweb.draw(), done()), problem });
    this.cobweb = new Cobweb(this, { change }, this.flat);
  }

  get classes() {
    return this.search.classes;
  }

  /** The diagram that another state asks for. @param {State} state */
  specOf(state) {
    return planned(this.machine, state, this.tolerance, workOf(state)).spec;
  }

  /** @param {State} state */
  show(state) {
    this.state = state;
    const { row, which, key, spec } = planned(this.machine, state, this.tolerance, workOf(state));
    this.#row = row;
    if (this.key === undefined) this.search.forget();
    if (key !== this.key) {
      this.key = key;
      this.diagram.show(spec);
    } else this.diagram.draw();
    this.search.ask("map", this.machine, { row, which, value: row[which], starts: DRAWN, transient: Math.max(2000, state.transient), seed: state.seed, tolerance: this.tolerance }, 0.01);
    this.cobweb.draw();
  }

  /** The cobweb or the plane, on the box of the map and where orbits are beyond it; where they fill little of it, on that. @returns {import("./cobweb.js").Web} */
  web() {
    const { machine, flat, state } = this, { coordinates } = machine.described, box = BROUGHT.model?.state ?? state, row = this.#row;
    const ends = [box.positions, box.velocities].slice(0, flat ? 2 : 1).map((home, i) => {
      const seen = this.classes.flatMap(({ points }) => points.map((point) => point[i])).filter(Number.isFinite);
      const own = [...seen, [state.x0, state.y0][i], [box.x0, box.y0][i]], tiny = seen.length && Math.max(...own) - Math.min(...own) < SMALL * (home[1] - home[0]);
      const low = Math.min(...own, tiny ? Infinity : home[0]), high = Math.max(...own, tiny ? -Infinity : home[1]), room = (tiny ? 0.2 : 0.04) * (high - low || SMALL * (home[1] - home[0]));
      return /** @type {import("./state.js").Pair} */ ([low - room, high + room]);
    });
    const drawn = JSON.stringify([Array.from(row), ends]);
    if (!flat && drawn !== this.#drawn) this.#graph = graphOf(machine, row, ends[0]);
    this.#drawn = drawn;
    const labels = /** @type {[string, string]} */ (flat ? coordinates : [`${coordinates[0]}ₙ`, `${coordinates[0]}ₙ₊₁`]);
    return { ends: [ends[0], ends[ends.length - 1]], labels, graph: this.#graph, walk: this.#walk().states };
  }

  /** A start and what follows it. */
  #walk() {
    const { x0, y0, web } = this.state, start = this.flat ? [x0, y0] : [x0], states = [start];
    const { points, letters } = web ? steps(this.machine, this.#row, Float64Array.from(start), 1, web) : { points: [], letters: [] };
    for (let n = 0; n < web && Number.isFinite(points[n * start.length]); n++) states.push(Array.from(points.slice(n * start.length, (n + 1) * start.length)));
    return { states, letters: Array.from(letters) };
  }

  /** What is shown, in words. */
  summary() {
    const { machine: { described: { fields, letters: names, coordinates } }, state } = this;
    const point = (/** @type {number[]} */ at) => (at.length > 1 ? `(${at.map((each) => numeral(each)).join(", ")})` : numeral(at[0]));
    /** @type {import("./state.js").Line[]} */
    const said = [{ text: `At ${fields.map((field) => `${plainSymbol(field)} = ${valueOf(state, field.name)}`).join(", ")}:` }];
    if (this.search.waiting) said.push({ text: SEARCHING });
    said.push(...words(this.classes));
    const { states, letters } = this.#walk(), visited = names ? letters.slice(0, states.length - 1).map((k) => [...names][k]).join("") : "";
    const where = coordinates.length > 1 ? `(${coordinates.join(", ")})` : coordinates[0];
    if (states.length > 1) said.push({ text: `From ${point(states[0])}: ${visited.length > 60 ? `…${visited.slice(-60)}` : visited}${visited ? ", " : ""}after ${states.length - 1} ${states.length > 2 ? "steps" : "step"} ${where} = ${point(states[states.length - 1])}${states.length - 1 < state.web ? "; then the orbit ends" : ""}.` });
    return said;
  }
}
