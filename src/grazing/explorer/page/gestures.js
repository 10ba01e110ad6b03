// @ts-check
/**
 * What a picture with axes answers to. A wheel and two fingers zoom, dragging moves the picture, or the line of the
 * parameter; at an axis, that axis alone. With Shift it chooses a part. A click picks, a double click shows all and picks nothing. Arrows
 * pick, + and − zoom, 0 shows all. A height that follows what is drawn is left to that, but at its axis and in a part that is chosen.
 */
import { theme } from "./colours.js";
import { select, zoom, zoomIdentity } from "./d3.mjs";

/** @typedef {import("./plot.js").Axes} Axes */
/** @typedef {[number, number]} Pair */
/** @typedef {() => void} Undo what takes a pick back */
/**
 * `chosen` says what the arrows move, a number that is not finite for a direction in which nothing is chosen; `steps`,
 * in how many steps they cross the picture; `redraw` draws it with the selection; `follows` says whether the height follows what is drawn,
 * which a zoom to null leaves to it; `held`, that a drag is not the picture's.
 * @typedef {{held?: boolean, ready: () => boolean, redraw: () => void, pick?: (x: number, y: number) => Undo, follows?: () => boolean, zoom?: (x: Pair, y: Pair | null) => void, zoomOut?: () => void, chosen?: () => Pair, steps?: () => Pair}} Answers
 */

/** A drag shorter than this is a click; one flatter or narrower than `FLAT` chooses along its long side only. */
const CLICK = 6, FLAT = 12;
/** Pixels beside the line at which it is taken, by a mouse and by a finger. */
const GRIP = 9, THUMB = 22;

/** @param {number} value @param {number} low @param {number} high */
const kept = (value, low, high) => Math.min(Math.max(value, low), high);

export class Gestures {
  /** @type {[number, number, number, number] | null} corners in CSS pixels */ selection = null;
  /** Whether the line of the parameter is dragged. */ #held = false;
  /** Where dragging with Shift began. @type {Pair | null} */ #corner = null;
  /** @type {Undo | undefined} */ #undo = undefined;

  /** @param {Axes} axes @param {Answers} answers */
  constructor(axes, answers) {
    this.axes = axes;
    this.answers = answers;
    const { canvas } = axes, on = canvas.addEventListener.bind(canvas);
    on("pointerdown", (event) => this.#down(event));
    on("pointermove", (event) => this.#over(event));
    on("pointerup", () => this.#up());
    on("pointercancel", () => this.#leave());
    on("click", (event) => this.#click(event));
    on("dblclick", () => {
      this.#undo?.();
      this.#undo = undefined;
      answers.zoomOut?.();
    });
    on("keydown", (event) => this.#key(event));
    if (answers.zoom) this.#move();
  }

  /** Let d3 read wheels, drags and fingers; the axes, and no transform, say what is shown. */
  #move() {
    const { axes, answers } = this, whole = select(axes.canvas);
    const behaviour = /** @type {import("./d3.mjs").ZoomBehavior<HTMLCanvasElement, unknown>} */ (zoom());
    /** A scale in CSS pixels. @param {import("./d3.mjs").ScaleLinear<number, number>} scale */
    const onScreen = (scale) => scale.copy().range(scale.range().map((end) => end * axes.zoom));
    let [x, y] = [onScreen(axes.x), onScreen(axes.y)];
    /** @type {Pair | null} */
    let from = null;
    /** Which axes the gesture zooms. */
    let [wide, high] = [true, true];
    behaviour
      .clickDistance(CLICK)
      // one finger scrolls the page, or drags the line
      .filter((event) => {
        if (event.touches?.length > 1) this.#held = false; // with a second finger the first one drags no line
        return answers.ready() && !(answers.held && event.type === "mousedown") && !event.button && !this.#held && !event.shiftKey && !(event.touches?.length < 2);
      })
      .on("start", ({ sourceEvent }) => {
        [x, y] = [onScreen(axes.x), onScreen(axes.y)];
        const [left, top] = axes.place(sourceEvent?.touches?.[0] ?? sourceEvent ?? { clientX: NaN, clientY: NaN }), { box } = axes;
        wide = !(left < box.x);
        high = !wide || (top <= box.y + box.h && !answers.follows?.());
        from = sourceEvent instanceof MouseEvent && sourceEvent.type === "mousedown" ? [sourceEvent.clientX, sourceEvent.clientY] : null;
      })
      .on("zoom", ({ sourceEvent, transform }) => {
        if (!sourceEvent) return;
        if (from && Math.hypot(sourceEvent.clientX - from[0], sourceEvent.clientY - from[1]) <= CLICK) return; // it may be a click
        from = null;
        answers.zoom?.(/** @type {Pair} */ ((wide ? transform.rescaleX(x) : x).domain()), high ? /** @type {Pair} */ (transform.rescaleY(y).domain()) : this.#height);
      })
      .on("end", ({ sourceEvent }) => sourceEvent && whole.call(behaviour.transform, zoomIdentity));
    whole.call(behaviour).on("dblclick.zoom", null);
  }

  /** The height as it is. @returns {Pair | null} */
  get #height() {
    return this.answers.follows?.() ? null : [this.axes.y0, this.axes.y1];
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

  /** The same on the axes, in the frame. @param {Pair} place @returns {Pair} */
  #at([x, y]) {
    const { axes } = this;
    return [kept(axes.atX(x), axes.x0, axes.x1), kept(axes.atY(y), axes.y0, axes.y1)];
  }

  /** Whether a pointer is at the line of the parameter, which stands where one is chosen across and nothing upwards. @param {PointerEvent} event */
  #near(event) {
    const [across, upwards] = this.answers.chosen?.() ?? [NaN, NaN];
    return Number.isNaN(upwards) && Math.abs(this.axes.x(across) - this.axes.place(event)[0]) <= (event.pointerType === "touch" ? THUMB : GRIP);
  }

  /** @param {PointerEvent} event */
  #down(event) {
    if (event.button || !event.isPrimary || !this.answers.ready()) return;
    this.#held = this.#near(event);
    this.#corner = event.shiftKey && this.answers.zoom ? this.axes.place(event) : null;
    if (this.#held || this.#corner) this.axes.canvas.setPointerCapture(event.pointerId);
  }

  /** @param {PointerEvent} event */
  #over(event) {
    const { axes, answers } = this, place = this.axes.place(event);
    if (!event.buttons) axes.canvas.style.cursor = answers.ready() && this.#near(event) ? "ew-resize" : "";
    if (this.#corner) {
      const [x, y] = this.#corner;
      this.selection = Math.hypot(place[0] - x, place[1] - y) > CLICK ? [x, y, ...place] : null;
      answers.redraw();
    } else if (this.#held && event.buttons) answers.pick?.(...this.#at(place));
  }

  #up() {
    const { axes, answers, selection } = this;
    this.#leave();
    if (!selection) return;
    const [x0, y0, x1, y1] = selection, [a, b] = [this.#at([x0, y0]), this.#at([x1, y1])];
    const ends = (/** @type {0 | 1} */ i) => /** @type {Pair} */ ([a[i], b[i]].sort((p, q) => p - q));
    answers.zoom?.(Math.abs(x1 - x0) < FLAT ? [axes.x0, axes.x1] : ends(0), Math.abs(y1 - y0) < FLAT ? this.#height : ends(1));
  }

  #leave() {
    const seen = this.selection;
    this.#corner = this.selection = null;
    if (seen && this.answers.ready()) this.answers.redraw();
    setTimeout(() => (this.#held = false)); // the click of this gesture comes next
  }

  /** @param {MouseEvent} event */
  #click(event) {
    if (event.detail > 1 || event.shiftKey || this.#held || !this.answers.ready()) return;
    this.#undo = this.answers.pick?.(...this.#at(this.axes.place(event)));
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
      answers.zoom?.(about(ends[0], 0), answers.follows?.() ? null : about(ends[1], 1));
      return true;
    };
    const act = /** @type {Record<string, () => boolean | void>} */ ({
      ArrowLeft: () => move(0, -1), ArrowRight: () => move(0, 1), ArrowDown: () => move(1, -1), ArrowUp: () => move(1, 1),
      "+": () => scale(0.5), "=": () => scale(0.5), "-": () => scale(2), 0: () => answers.zoomOut?.(),
    })[event.key];
    if (act && act() !== false) event.preventDefault();
  }
}
