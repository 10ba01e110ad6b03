// @ts-check
/** The cobweb of the gap map: the orbits that starts settle on, and one that is stepped from a start that can be dragged. */
import { periodColour, theme } from "./colours.js";
import { Axes } from "./plot.js";
import { tidy } from "./state.js";

/** @typedef {import("./state.js").State} State */

/** Pixels from the start at which it is taken; a key moves it by this share of the picture; steps at most. */
const GRIP = 24, NUDGE = 0.01, MOST = 400;

/** One step of the map. @param {State} state @param {number} x */
export const stepped = ({ lam, mu, l }, x) => (x < 0 ? lam * x + mu : mu - l - Math.sqrt(x));

/** A start and what follows it. @param {State} state */
export function walk(state) {
  const found = [state.x0];
  for (let n = 0; n < state.web; n++) found.push(stepped(state, found[n]));
  return found;
}

export class Cobweb {
  #held = false;

  /**
   * @param {{state: State, classes: import("./jobs.js").Class[]}} view
   * @param {Pick<import("./state.js").Events, "change">} told
   */
  constructor(view, { change }) {
    this.view = view;
    this.change = change;
    this.axes = new Axes(document.getElementById("cobweb"), { equal: true });
    const { canvas } = this.axes;
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button || !event.isPrimary || !view.state || (event.pointerType === "touch" && !this.#near(event))) return;
      this.#held = true;
      canvas.setPointerCapture(event.pointerId);
      this.#drag(event);
    });
    canvas.addEventListener("pointermove", (event) => this.#held && this.#drag(event));
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (this.#held = false));
    canvas.addEventListener("touchstart", (event) => this.#near(event.touches[0]) && event.preventDefault(), { passive: false });
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  /** One step further, or back. */
  step(by = 1) {
    this.change({ web: Math.min(Math.max(this.view.state.web + by, 0), MOST) });
  }

  /** @param {{clientX: number, clientY: number}} event */
  #near(event) {
    const [x, y] = this.axes.place(event), { x0 } = this.view.state;
    return Math.hypot(this.axes.x(x0) - x, this.axes.y(x0) - y) < GRIP;
  }

  /** @param {number} x */
  #begin(x) {
    const { x0, x1 } = this.axes;
    this.change({ x0: tidy(Math.min(Math.max(x, x0), x1), x1 - x0), web: this.view.state.web || 1 });
  }

  /** @param {PointerEvent} event */
  #drag(event) {
    this.#begin(this.axes.atX(this.axes.place(event)[0]));
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const { x0, x1 } = this.axes, nudge = (x1 - x0) * NUDGE * (event.shiftKey ? 0.1 : 1), at = this.view.state.x0;
    const act = /** @type {Record<string, () => void>} */ ({
      ArrowLeft: () => this.#begin(at - nudge), ArrowRight: () => this.#begin(at + nudge),
      s: () => this.step(), S: () => this.step(), " ": () => this.step(), Backspace: () => this.step(-1), 0: () => this.change({ web: 0 }),
    })[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  }

  draw() {
    const { axes } = this, { state, classes } = this.view, { lam, mu, l, x0 } = state;
    const seen = classes.flatMap((each) => each.points.map(([x]) => x)).filter(Number.isFinite);
    let low = Math.min(mu - l - Math.sqrt(Math.max(mu, 0)), ...seen, -0.02), high = Math.max(mu, ...seen, 0.02);
    const room = 0.08 * (high - low);
    low -= room;
    high += room;
    axes.span(low, high, low, high);
    const c = axes.begin(), { faint, line, ink, graze, paper } = theme();
    /** @param {number[][]} points @param {string} colour @param {number} width @param {number[]} dash */
    const path = (points, colour, width, dash = []) => {
      c.strokeStyle = colour;
      c.lineWidth = width;
      c.setLineDash(dash);
      c.beginPath();
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
      path([[low, low], [high, high]], faint, 1, [4, 3]);
      path([[0, low], [0, high]], line, 1);
      path([[low, 0], [high, 0]], line, 1);
      path([[low, lam * low + mu], [0, mu]], ink, 1.8);
      path(Array.from({ length: 121 }, (_, i) => { const x = high * (i / 120) ** 2; return [x, stepped(state, x)]; }), ink, 1.8);
      for (const { period, points } of [...classes].reverse()) {
        const xs = points.map(([x]) => x), colour = periodColour(period);
        path(stairs(period > 0 ? [...xs, xs[0]] : xs), colour, period > 0 ? 1.6 : 0.6);
        c.fillStyle = colour;
        if (period > 0) for (const x of xs) dot(x, stepped(state, x));
      }
      const own = walk(state);
      path(stairs(own), graze, 2.2);
      c.fillStyle = graze;
      if (own.length > 1) dot(own[own.length - 1], own[own.length - 1], 4);
      dot(x0, x0, 8);
      c.fillStyle = paper;
      dot(x0, x0, 4);
    });
    axes.frame("xₙ", "xₙ₊₁");
  }
}
