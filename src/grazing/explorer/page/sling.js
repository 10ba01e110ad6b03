// @ts-check
/** The ball is taken, aimed with its flight before the eyes, and let go: in the portrait or the strip, or by keys. */
import { flown } from "./flight.js";
import { inside } from "./walls.js";

/** What is aimed: where the ball begins, the flight from there, and in the strip where the pointer took it. @typedef {{u: number, v: number, flight: ReturnType<typeof flown>, pen: number | null}} Aim */

/** Periods that are foreseen; pixels from the ball at which a finger takes it, and by which it is pulled at least; a key aims by this share of the portrait. */
const AHEAD = 5, GRIP = 48, PULL = 6, NUDGE = 0.02;

export class Sling {
  /** @type {Aim | null} */ aim = null;
  /** Where the pointer took the ball in the strip, and the height there. @type {{x: number, y: number, u: number, pen: number} | null} */ #taken = null;

  /** The pointer that aims: fingers have a capture of their own, each. */ #pointer = NaN;

  /** @param {import("./ball.js").BallView} view */
  constructor(view) {
    this.view = view;
    for (const axes of [view.axes, view.strip.axes]) {
      const { canvas } = axes, holds = (/** @type {PointerEvent} */ { pointerId }) => pointerId === this.#pointer && canvas.hasPointerCapture(pointerId);
      canvas.addEventListener("pointerdown", (event) => {
        if (event.button || event.shiftKey || !event.isPrimary || !view.state || !this.#takes(event, axes)) return;
        canvas.setPointerCapture((this.#pointer = event.pointerId));
        canvas.focus({ preventScroll: true });
        this.#drag(event, axes);
      });
      canvas.addEventListener("pointermove", (event) => holds(event) && this.#drag(event, axes));
      canvas.addEventListener("pointerup", (event) => holds(event) && this.let());
      canvas.addEventListener("pointercancel", () => this.#stop());
      canvas.addEventListener("keydown", (event) => this.#key(event));
      canvas.addEventListener("blur", () => this.#stop()); // no ball hangs in the air while the hand is elsewhere
      // a finger that takes the ball does not scroll the page
      canvas.addEventListener("touchstart", (event) => {
        if (event.touches.length === 1) return this.#grips(event.touches[0], axes) && event.preventDefault();
        this.#pointer = NaN; // two fingers zoom
        this.#stop();
      }, { passive: false });
    }
  }

  /** Let the ball go. */
  let() {
    const { aim } = this;
    this.#stop();
    if (aim) this.view.throw(aim.u, aim.v);
  }

  #stop() {
    if (!this.aim) return;
    this.aim = this.#taken = null;
    this.view.draw();
  }

  /** @param {number} u @param {number} v @param {number | null} pen */
  #at(u, v, pen) {
    const { view } = this, above = inside(view.state, u, view.state.phase);
    this.aim = { u: above, v, pen, flight: flown(view.machine, view.model, above, v, AHEAD) };
    view.draw();
  }

  /** Whether a finger is at the ball, or in the portrait, where the ball may be put anywhere. @param {{clientX: number, clientY: number}} touch @param {import("./plot.js").Axes} axes */
  #grips(touch, axes) {
    const { view } = this;
    if (axes === view.axes) return true;
    const [x, y] = axes.place(touch), ball = view.strip.ball;
    return Math.hypot(x - ball[0], y - ball[1]) < GRIP;
  }

  /** @param {PointerEvent} event @param {import("./plot.js").Axes} axes */
  #takes(event, axes) {
    const [x, y] = axes.place(event), { view } = this, { box } = axes;
    if (axes === view.axes) return x >= box.x && y >= box.y && y <= box.y + box.h;
    const grips = this.#grips(event, axes);
    if (y > box.y + box.h + GRIP || (event.pointerType === "touch" && !grips)) return false;
    this.#taken = { x, y, u: grips ? view.place[0] : inside(view.state, axes.atY(y), view.state.phase), pen: Math.min(Math.max(x, box.x + 0.1 * box.w), box.x + 0.9 * box.w) };
    return true;
  }

  /** @param {PointerEvent} event @param {import("./plot.js").Axes} axes */
  #drag(event, axes) {
    const [x, y] = axes.place(event), portrait = this.view.axes, taken = this.#taken;
    if (axes === portrait) return this.#at(axes.atX(Math.min(Math.max(x, axes.box.x), axes.box.x + axes.box.w)), axes.atY(Math.min(Math.max(y, axes.box.y), axes.box.y + axes.box.h)), null);
    // a click into the strip throws nothing; as with a sling, the ball flies the other way than it is pulled
    if (taken && (this.aim || Math.hypot(x - taken.x, y - taken.y) > PULL)) this.#at(taken.u, ((y - taken.y) / axes.box.h) * (portrait.y1 - portrait.y0), taken.pen);
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || !this.view.state) return;
    const { view } = this, { x0, x1, y0, y1 } = view.axes, size = NUDGE * (event.shiftKey ? 0.1 : 1), [u, v] = this.aim ? [this.aim.u, this.aim.v] : view.place;
    const act = /** @type {Record<string, () => void>} */ ({
      ArrowLeft: () => this.#at(u - size * (x1 - x0), v, null), ArrowRight: () => this.#at(u + size * (x1 - x0), v, null),
      ArrowDown: () => this.#at(u, v - size * (y1 - y0), null), ArrowUp: () => this.#at(u, v + size * (y1 - y0), null),
      Enter: () => this.let(), Escape: () => this.#stop(),
    })[event.key];
    if (!act || (event.key === "Escape" && !this.aim)) return;
    event.preventDefault();
    act();
  }
}
