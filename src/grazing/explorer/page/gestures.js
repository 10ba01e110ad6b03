// @ts-check
/** What a picture with axes answers to: a click picks, dragging zooms, or moves the line of the parameter; double click and 0 zoom out; arrows move, + and - zoom. */
import { theme } from "./colours.js";

/** @typedef {import("./plot.js").Axes} Axes */
/** @typedef {[number, number]} Pair */
/**
 * `chosen` says what the arrows move, a number that is not finite for a direction in which nothing is chosen; `steps`,
 * in how many steps they cross the picture; `redraw` draws it with the selection.
 * @typedef {{ready: () => boolean, redraw: () => void, pick?: (x: number, y: number) => void, zoom?: (x: Pair, y: Pair) => void, zoomOut?: () => void, chosen?: () => Pair, steps?: () => Pair}} Answers
 */

/** A drag shorter than this is a click; one flatter or narrower than `FLAT` zooms along its long side only. */
const CLICK = 6, FLAT = 12;

/** @param {number} value @param {number} low @param {number} high */
const kept = (value, low, high) => Math.min(Math.max(value, low), high);

export class Gestures {
  /** @type {[number, number, number, number] | null} corners in CSS pixels */ selection = null;
  /** @type {Pair | null} where a drag began */ #from = null;
  /** Whether the line of the parameter is dragged. */ #held = false;

  /** @param {Axes} axes @param {Answers} answers */
  constructor(axes, answers) {
    this.axes = axes;
    this.answers = answers;
    const { canvas } = axes;
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button || !answers.ready()) return;
      this.#from = this.#place(event);
      this.#held = this.#near(event);
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!event.buttons) canvas.style.cursor = answers.ready() && this.#near(event) ? "ew-resize" : "";
      if (this.#held && this.#from) return this.#pick(event);
      if (!this.#from || !answers.zoom) return;
      const to = this.#place(event), from = this.#from;
      this.selection = Math.hypot(to[0] - from[0], to[1] - from[1]) > CLICK ? [...from, ...to] : null;
      answers.redraw();
    });
    canvas.addEventListener("pointerup", (event) => this.#end(event));
    canvas.addEventListener("pointercancel", () => {
      this.#from = this.selection = null;
      this.#held = false;
      if (answers.ready()) answers.redraw();
    });
    canvas.addEventListener("dblclick", () => answers.zoomOut?.());
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  /** Draw the selection over the picture. @param {import("./svg.js").Pen} c */
  draw(c) {
    if (!this.selection) return;
    const [x0, y0, x1, y1] = this.selection;
    c.strokeStyle = theme().accent;
    c.fillStyle = theme().accent + "22";
    c.lineWidth = 1;
    c.fillRect(Math.min(x0, x1), Math.min(y0, y1), Math.abs(x1 - x0), Math.abs(y1 - y0));
    c.strokeRect(Math.min(x0, x1), Math.min(y0, y1), Math.abs(x1 - x0), Math.abs(y1 - y0));
  }

  /** @param {MouseEvent} event @returns {Pair} */
  #place(event) {
    const { left, top } = this.axes.canvas.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  }

  /** Whether a pointer is at the line of the parameter, which stands where one is chosen across and nothing upwards. @param {PointerEvent} event */
  #near(event) {
    const [across, upwards] = this.answers.chosen?.() ?? [NaN, NaN];
    return Number.isNaN(upwards) && Math.abs(this.axes.x(across) - this.#place(event)[0]) <= (event.pointerType === "touch" ? 22 : 9);
  }

  /** @param {PointerEvent} event */
  #pick(event) {
    const { axes, answers } = this, [x, y] = this.#place(event);
    answers.pick?.(kept(axes.atX(x), axes.x0, axes.x1), kept(axes.atY(y), axes.y0, axes.y1));
  }

  /** @param {PointerEvent} event */
  #end(event) {
    if (!this.#from) return;
    const { axes, answers } = this;
    if (this.#held) {
      this.#held = false;
      this.#from = null;
      return this.#pick(event);
    }
    const [x, y] = this.#place(event), [fromX, fromY] = this.#from;
    const atX = (/** @type {number} */ place) => kept(axes.atX(place), axes.x0, axes.x1);
    const atY = (/** @type {number} */ place) => kept(axes.atY(place), axes.y0, axes.y1);
    this.#from = null;
    if (!this.selection) return answers.pick?.(atX(x), atY(y));
    this.selection = null;
    const xs = /** @type {Pair} */ ([atX(fromX), atX(x)].sort((a, b) => a - b));
    const ys = /** @type {Pair} */ ([atY(fromY), atY(y)].sort((a, b) => a - b));
    if (Math.abs(y - fromY) < FLAT) answers.zoom?.(xs, [axes.y0, axes.y1]);
    else if (Math.abs(x - fromX) < FLAT) answers.zoom?.([axes.x0, axes.x1], ys);
    else answers.zoom?.(xs, ys);
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const { axes, answers } = this;
    if (!answers.ready() || event.ctrlKey || event.metaKey || event.altKey) return;
    const ends = /** @type {[Pair, Pair]} */ ([[axes.x0, axes.x1], [axes.y0, axes.y1]]);
    const chosen = (answers.chosen?.() ?? [NaN, NaN]).map((value, i) => (Number.isFinite(value) ? kept(value, ...ends[i]) : NaN));
    const move = (/** @type {number} */ i, /** @type {number} */ sign) => {
      if (!Number.isFinite(chosen[i])) return false;
      const [low, high] = ends[i], steps = answers.steps?.()[i] ?? 100;
      const to = [...chosen];
      to[i] = kept(chosen[i] + ((sign * (high - low)) / Math.max(steps, 1)) * (event.shiftKey ? 20 : 1), low, high);
      answers.pick?.(to[0], to[1]);
      return true;
    };
    const scale = (/** @type {number} */ factor) => {
      const about = (/** @type {Pair} */ [low, high], /** @type {number} */ i) => {
        if (answers.chosen && !Number.isFinite(chosen[i])) return /** @type {Pair} */ ([low, high]);
        const centre = Number.isFinite(chosen[i]) ? chosen[i] : (low + high) / 2;
        return /** @type {Pair} */ ([centre - (centre - low) * factor, centre + (high - centre) * factor]);
      };
      answers.zoom?.(about(ends[0], 0), about(ends[1], 1));
      return true;
    };
    const act = /** @type {Record<string, () => boolean | void>} */ ({
      ArrowLeft: () => move(0, -1), ArrowRight: () => move(0, 1), ArrowDown: () => move(1, -1), ArrowUp: () => move(1, 1),
      "+": () => scale(0.5), "=": () => scale(0.5), "-": () => scale(2), 0: () => answers.zoomOut?.(),
    })[event.key];
    if (act && act() !== false) event.preventDefault();
  }
}
