// @ts-check
/** A table as it is seen: what stands on it, flippers where they are, the ball with its way behind it, its ghosts. */
import { theme } from "./colours.js";
import { enlarged } from "./plot.js";

/** @typedef {import("./played.js").Played} Played */
/** @typedef {import("./played.js").Thing} Thing */

/** Colours of the ways out, told apart without red and green; then of balls that do not leave. */
export const EXITS = ["#0064a4", "#e69f00", "#00826a", "#e08fbf", "#5cbceb", "#b3b53c", "#5b2c83", "#f2a07b"];
/** Seconds for which an object flashes, and for which the ball's way is seen. */
const FLASH = 0.25, TRAIL = 0.6;
/** Milliseconds for which a nudged table is seen to move, and by how many pixels. */
const SHAKES = 220, SHAKEN = 14;
/** Parts of a second between two points of that way. */
const FINE = 1 / 120;

/** Whether an object kicks. @param {Thing} one */
export const kicks = (one) => Boolean(one.law?.params.includes("V")) && one.kind !== "flipper";

/** The middle of an object. @param {Thing} one */
const centre = ({ kind, shape }) => (kind === "segment" ? { x: (shape.x1 + shape.x2) / 2, y: (shape.y1 + shape.y2) / 2 } : { x: shape.x, y: shape.y });

export class TableDraw {
  /** @type {{t: number, x: number, y: number}[]} */ trail = [];

  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  }

  /** Fit the table into the canvas. @param {[number, number, number, number]} box @param {number} rho */
  #fit([x0, x1, y0, y1], rho) {
    const ratio = window.devicePixelRatio || 1, { clientWidth: w, clientHeight: h } = this.canvas;
    const [W, H] = [Math.max(1, Math.round(w * ratio)), Math.max(1, Math.round(h * ratio))];
    if (this.canvas.width !== W || this.canvas.height !== H) Object.assign(this.canvas, { width: W, height: H });
    const room = 3 * Math.max(rho, 0.01 * (x1 - x0)), scale = Math.min(w / (x1 - x0 + room), h / (y1 - y0 + room));
    this.scale = scale;
    this.left = w / 2 - (scale * (x0 + x1)) / 2;
    this.bottom = h / 2 + (scale * (y0 + y1)) / 2;
    const { at, across, up } = this.#shaken, part = (performance.now() - at) / SHAKES, moved = part < 1 ? SHAKEN * Math.sin(Math.PI * part) * (1 - part) : 0;
    this.left -= moved * across;
    this.bottom += moved * up;
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
  }

  scale = 1;
  left = 0;
  bottom = 0;
  x = (/** @type {number} */ x) => this.left + this.scale * x;
  y = (/** @type {number} */ y) => this.bottom - this.scale * y;
  atX = (/** @type {number} */ px) => (px - this.left) / this.scale;
  atY = (/** @type {number} */ py) => (this.bottom - py) / this.scale;

  /** @type {{at: number, across: number, up: number}} */ #shaken = { at: -Infinity, across: 0, up: 0 };

  /** The table is nudged: it is seen to move, unless the reader wants nothing to. @param {number} across @param {number} up */
  shake(across, up) {
    if (!matchMedia("(prefers-reduced-motion: reduce)").matches) this.#shaken = { at: performance.now(), across, up };
  }

  /** Forget the way behind the ball. */
  clear() {
    this.trail = [];
  }

  /** Remember where the ball is. @param {Played} game */
  follow(game) {
    const [x, y] = game.place, last = this.trail.at(-1);
    for (const hit of game.hits.slice(-12)) {
      if (last && hit.t > last.t && hit.t <= game.t) this.trail.push({ t: hit.t, x: hit.x, y: hit.y });
    }
    if (!last || game.t - last.t > FINE) this.trail.push({ t: game.t, x, y });
    while (this.trail.length && this.trail[0].t < game.t - TRAIL) this.trail.shift();
  }

  /** @param {Played} game @param {{letters: Map<number, string>, aim: [number, number] | null, chosen?: number, at: number}} more letters of objects, where a launch is aimed, the object that is edited, and a time in seconds for flashes */
  draw(game, { letters, aim, chosen = -1 }) {
    const { context: c } = this, { table } = game, colours = theme(), { paper, ink, faint, accent, graze } = colours;
    this.#fit(table.box, table.rho);
    c.fillStyle = paper;
    c.fillRect(0, 0, this.canvas.clientWidth, this.canvas.clientHeight);
    c.lineCap = "round";
    c.lineJoin = "round";
    const lit = new Map(game.hits.slice(-40).map((hit) => [hit.owner, 1 - (game.t - hit.t) / FLASH]));
    const ways = game.things.filter((one) => one.kind === "drain").map((one) => one.name);
    game.things.forEach((one, j) => {
      const glow = Math.max(0, Math.min(1, lit.get(j) ?? 0)), active = kicks(one);
      c.strokeStyle = active ? graze : faint;
      c.lineWidth = active ? 4 : 3;
      this.#path(one, game);
      if (one.kind === "disc") {
        c.fillStyle = active ? paper : faint;
        c.fill();
        if (active) {
          c.globalAlpha = 0.16 + 0.7 * glow;
          c.fillStyle = graze;
          c.fill();
          c.globalAlpha = 1;
        }
      }
      if (one.kind === "flipper") {
        c.fillStyle = accent;
        c.fill();
        return;
      }
      if (one.kind === "drain") {
        c.strokeStyle = EXITS[ways.indexOf(one.name) % EXITS.length];
        c.setLineDash([2, 7]);
        c.stroke();
        c.setLineDash([]);
        return;
      }
      c.lineWidth += 4 * glow;
      if (j === chosen) Object.assign(c, { strokeStyle: accent, lineWidth: 6 });
      c.stroke();
      const letter = letters.get(j);
      if (letter) {
        const { x, y } = centre(one), least = 14 * enlarged(), size = one.kind === "disc" ? Math.min(2 * least, Math.max(least, this.scale * one.shape.radius)) : least;
        c.fillStyle = one.kind === "disc" && !active ? paper : ink; // on its own grey
        c.font = `600 ${size}px system-ui, sans-serif`;
        c.textAlign = "center";
        c.textBaseline = "middle";
        if (one.kind !== "disc") this.#plate(x, y, size);
        c.fillText(letter, this.x(x), this.y(y));
      }
    });
    this.#balls(game);
    if (aim) this.#aim(aim);
  }

  /** Paper behind a letter. @param {number} x @param {number} y @param {number} size */
  #plate(x, y, size) {
    const { context: c } = this, before = c.fillStyle;
    c.fillStyle = theme().paper;
    c.beginPath();
    c.arc(this.x(x), this.y(y), 0.7 * size, 0, 2 * Math.PI);
    c.fill();
    c.fillStyle = before;
  }

  /** The outline of an object. @param {Thing} one @param {Played} game */
  #path({ kind, shape, name }, game) {
    const { context: c } = this;
    c.beginPath();
    if (kind === "disc") c.arc(this.x(shape.x), this.y(shape.y), Math.max(1.5, this.scale * shape.radius), 0, 2 * Math.PI);
    else if (kind === "arc") c.arc(this.x(shape.x), this.y(shape.y), this.scale * shape.radius, -shape.start, -shape.stop, true);
    else if (kind === "flipper") {
      const a = game.angle(name), lean = Math.acos((shape.hub - shape.tip) / shape.length);
      const tip = [shape.x + shape.length * Math.cos(a), shape.y + shape.length * Math.sin(a)];
      c.arc(this.x(shape.x), this.y(shape.y), this.scale * shape.hub, -(a + lean), -(a - lean + 2 * Math.PI), true);
      c.arc(this.x(tip[0]), this.y(tip[1]), this.scale * shape.tip, -(a - lean), -(a + lean), true);
      c.closePath();
    } else {
      c.moveTo(this.x(shape.x1), this.y(shape.y1));
      c.lineTo(this.x(shape.x2), this.y(shape.y2));
    }
  }

  /** @param {Played} game */
  #balls(game) {
    const { context: c, trail } = this, { ink, accent } = theme();
    const size = Math.max(3.5, this.scale * game.table.rho);
    c.fillStyle = accent;
    c.globalAlpha = 0.35;
    for (const [x, y] of game.flying) {
      c.beginPath();
      c.arc(this.x(x), this.y(y), Math.max(2, 0.6 * size), 0, 2 * Math.PI);
      c.fill();
    }
    c.globalAlpha = 1;
    c.strokeStyle = ink;
    c.lineWidth = 1.5;
    for (let i = 1; i < trail.length; i++) {
      c.globalAlpha = 0.5 * Math.max(0, 1 - (game.t - trail[i].t) / TRAIL);
      c.beginPath();
      c.moveTo(this.x(trail[i - 1].x), this.y(trail[i - 1].y));
      c.lineTo(this.x(trail[i].x), this.y(trail[i].y));
      c.stroke();
    }
    c.globalAlpha = 1;
    if (!game.alive) return;
    const [x, y] = game.place;
    c.beginPath();
    c.arc(this.x(x), this.y(y), size, 0, 2 * Math.PI);
    c.fillStyle = ink;
    c.fill();
  }

  /** The ball that waits, and how hard it will be launched. @param {[number, number]} aim */
  #aim([x, y]) {
    const { context: c } = this, { ink } = theme();
    c.beginPath();
    c.arc(this.x(x), this.y(y), 5, 0, 2 * Math.PI);
    c.strokeStyle = ink;
    c.lineWidth = 2;
    c.stroke();
  }
}
