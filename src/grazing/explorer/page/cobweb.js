// @ts-check
/**
 * The cobweb of a map of one coordinate, or the plane of one of two: the orbits that starts settle on, and one that is stepped from a start
 * that can be dragged.
 */
import { periodColour, theme } from "./colours.js";
import { Axes } from "./plot.js";
import { later, tidy } from "./state.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./state.js").Pair} Pair */
/**
 * What a view says of its map: the ends of the axes and their names, the graph in pieces (none in the plane), lines through `cross`, and
 * the states of the orbit that is stepped.
 * @typedef {{ends: [Pair, Pair], labels: [string, string], graph: number[][][], cross?: number, walk: number[][]}} Web
 */

/** Pixels from the start at which it is taken; a key moves it by this share of the picture; steps at most. */
const GRIP = 24, NUDGE = 0.01, MOST = 400;

export class Cobweb {
  #held = false;
  /** @type {[Pair, Pair] | null} where the start may be dragged: axes that follow it would run away */ #within = null;

  /**
   * @param {{state: State, classes: import("./jobs.js").Class[], web: () => Web}} view
   * @param {Pick<import("./state.js").Events, "change">} told
   * @param {boolean} flat whether it is the plane of two coordinates
   */
  constructor(view, { change }, flat = false) {
    this.view = view;
    this.flat = flat;
    this.change = change;
    this.axes = new Axes(document.getElementById("cobweb"), { equal: true });
    const { canvas } = this.axes;
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button || !event.isPrimary || !view.state || (event.pointerType === "touch" && !this.#near(event))) return;
      this.#held = true;
      this.#within = [[this.axes.x0, this.axes.x1], [this.axes.y0, this.axes.y1]];
      canvas.setPointerCapture(event.pointerId);
      this.#drag(event);
    });
    canvas.addEventListener("pointermove", (event) => this.#held && this.#drag(event));
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { this.#held = false; this.#within = null; });
    canvas.addEventListener("touchstart", (event) => this.#near(event.touches[0]) && event.preventDefault(), { passive: false });
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  /** One step further, or back. */
  step(by = 1) {
    this.change({ web: Math.min(Math.max(this.view.state.web + by, 0), MOST) });
  }

  /** @param {{clientX: number, clientY: number}} event */
  #near(event) {
    const [x, y] = this.axes.place(event), [x0, y0] = this.#start;
    return Math.hypot(this.axes.x(x0) - x, this.axes.y(y0) - y) < GRIP;
  }

  /** Where the start is drawn. @returns {Pair} */
  get #start() {
    const { x0, y0 } = this.view.state;
    return [x0, this.flat ? y0 : x0];
  }

  /** @param {number} x @param {number} y */
  #begin(x, y) {
    const [[x0, x1], [y0, y1]] = this.#within ?? [[this.axes.x0, this.axes.x1], [this.axes.y0, this.axes.y1]], within = (/** @type {number} */ value, /** @type {number} */ low, /** @type {number} */ high) => tidy(Math.min(Math.max(value, low), high), high - low);
    this.change({ x0: within(x, x0, x1), ...(this.flat ? { y0: within(y, y0, y1) } : {}), web: this.view.state.web || 1 });
  }

  /** @param {PointerEvent} event */
  #drag(event) {
    const [x, y] = this.axes.place(event);
    this.#begin(this.axes.atX(x), this.axes.atY(y));
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const { x0, x1, y0, y1 } = this.axes, part = NUDGE * (event.shiftKey ? 0.1 : 1), across = (x1 - x0) * part, up = (y1 - y0) * part, [x, y] = this.#start;
    const act = /** @type {Record<string, () => void>} */ ({
      ArrowLeft: () => this.#begin(x - across, y), ArrowRight: () => this.#begin(x + across, y),
      ...(this.flat ? { ArrowUp: () => this.#begin(x, y + up), ArrowDown: () => this.#begin(x, y - up) } : {}),
      s: () => this.step(), S: () => this.step(), " ": () => this.step(), Backspace: () => this.step(-1), 0: () => this.change({ web: 0 }),
    })[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  }

  draw() {
    const { axes, flat } = this, { classes } = this.view, { ends, labels, graph, cross, walk } = this.view.web(), [[low, high], [bottom, top]] = ends;
    axes.span(low, high, bottom, top);
    const c = axes.begin(), { faint, line, ink, graze, paper } = theme();
    /** @param {number[][]} points @param {string} colour @param {number} width @param {number[]} dash */
    const path = (points, colour, width, dash = []) => {
      c.strokeStyle = colour;
      c.lineWidth = width;
      c.setLineDash(dash);
      c.beginPath();
      if (points.length === 1) c.arc(axes.x(points[0][0]), axes.y(points[0][1]), width / 4, 0, 7); // of a graph too steep to be joined
      points.forEach(([x, y], i) => (i ? c.lineTo(axes.x(x), axes.y(y)) : c.moveTo(axes.x(x), axes.y(y))));
      c.stroke();
      c.setLineDash([]);
    };
    const dot = (/** @type {number} */ x, /** @type {number} */ y, radius = 3) => {
      c.beginPath();
      c.arc(axes.x(x), axes.y(y), radius, 0, 7);
      c.fill();
    };
    /** The stairs between map and diagonal. @param {number[]} xs */
    const stairs = (xs) => xs.slice(1).flatMap((next, n) => [[xs[n], xs[n]], [xs[n], next], [next, next]]);
    axes.inside(() => {
      if (!flat) path([[low, low], [high, high]], faint, 1, [4, 3]);
      if (cross !== undefined) for (const ends of [[[cross, bottom], [cross, top]], [[low, cross], [high, cross]]]) path(ends, line, 1);
      for (const piece of graph) path(piece, ink, 1.8);
      for (const { period, points } of [...classes].reverse()) {
        const xs = points.map(([x]) => x), around = period > 0 ? [...xs, xs[0]] : xs, colour = periodColour(period);
        if (!flat) path(stairs(around), colour, period > 0 ? 1.6 : 0.6);
        c.fillStyle = colour;
        points.forEach(([x, y], n) => (flat ? dot(x, y, period > 0 ? 4 : 1.5) : period > 0 && dot(x, around[n + 1])));
      }
      const at = walk.map(([x, y]) => [x, flat ? y : x]), [last] = at.slice(-1);
      path(flat ? at : stairs(walk.map(([x]) => x)), graze, flat ? 1 : 2.2);
      c.fillStyle = graze;
      if (flat) for (const [x, y] of at) dot(x, y, 2.5);
      if (at.length > 1) dot(last[0], last[1], 4);
      const [x, y] = this.#start;
      dot(x, y, 8);
      c.fillStyle = paper;
      dot(x, y, 4);
    });
    axes.frame(labels[0], labels[1]);
  }
}

/** A view of a diagram with a cobweb beside it. */
export class Beside {
  /** @type {State} */ state = later();
  /** @type {string | undefined} what is computed, undefined for nothing */ key = undefined;
  /** @type {import("./diagram.js").Diagram} */ diagram = later();
  /** @type {Cobweb} */ cobweb = later();

  get canvas() {
    return this.diagram.axes.canvas;
  }

  /** @returns {import("./svg.js").Panel[]} */
  panels() {
    return [this.diagram, this.cobweb].map((each) => ({ sheet: each.axes, draw: () => each.draw() }));
  }

  repaint() {
    this.diagram.paint();
    if (this.state) this.cobweb.draw();
  }

  raster() {
    return this.diagram.spec;
  }
}
