// @ts-check
/** Through which drain a ball leaves, over the angle and speed of its launch: a picture that gets finer, to be clicked. */
import { theme, rgb } from "./colours.js";
import { linspace } from "./jobs.js";
import { Axes } from "./plot.js";
import { EXITS } from "./tabledraw.js";

/** @typedef {import("./played.js").Played} Played */

/** Sides of a picture, coarse first. */
export const SIDES = [40, 160, 320];
/** Rows of one job; impacts after which a launch is given up. */
const ROWS = 8, MOST = 1500;

export class Exits {
  /** @type {ImageData | null} */ #image = null;
  #side = 0;
  /** @type {[number, number] | null} the launch that was chosen: angle and speed */ chosen = null;
  key = "";
  /** Rows that are still to come at this side. */
  left = 0;

  /** @param {HTMLCanvasElement} canvas @param {import("./pool.js").Pool} pool @param {() => void} counted what is done when shares are known, coarse or fine @param {(angle: number, speed: number) => void} choose @param {(text: string) => void} problem */
  constructor(canvas, pool, counted, choose, problem) {
    this.axes = new Axes(canvas, { top: 30 });
    this.pool = pool;
    this.counted = counted;
    this.problem = problem;
    /** @type {(angle: number, speed: number) => void} */
    this.choose = (angle, speed) => {
      this.chosen = [angle, speed];
      choose(angle, speed);
      this.draw();
    };
    canvas.addEventListener("click", (event) => {
      const { axes } = this, [x, y] = axes.place(event), angle = axes.atX(x), speed = axes.atY(y);
      if (angle >= axes.x0 && angle <= axes.x1 && speed >= 0 && speed <= axes.y1) this.choose(angle, speed);
    });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      if (!step) return;
      event.preventDefault();
      event.stopPropagation();
      const { axes } = this, [angle, speed] = this.chosen ?? [(axes.x0 + axes.x1) / 2, axes.y1 / 2];
      const within = (/** @type {number} */ x, /** @type {number} */ low, /** @type {number} */ high) => Math.min(high, Math.max(low, x));
      this.choose(within(angle + (step[0] * (axes.x1 - axes.x0)) / 200, axes.x0, axes.x1), within(speed + (step[1] * axes.y1) / 200, 0, axes.y1));
    });
  }

  /** Show the exits of a table as it is now, flippers at rest. @param {Played} game */
  async show(game) {
    const { table } = game, key = JSON.stringify([table.params.length, table.box, game.values]);
    if (key === this.key) return this.draw();
    this.key = key;
    const [x, y, fastest] = table.from, batch = this.pool.batch("exits");
    this.axes.span(0, 2 * Math.PI, 0, fastest);
    const ways = table.objects.map((one) => one.kind === "drain").reduce((/** @type {number[]} */ all, is, j) => (is ? [...all, j] : all), []);
    this.names = ways.map((j) => table.objects[j].name);
    this.shares = new Float64Array(ways.length + 1);
    const block = game.atRest;
    for (const side of SIDES) {
      const angle = linspace(0, 2 * Math.PI, side), speed = linspace(0, fastest, side);
      const image = new ImageData(side, side), counts = new Float64Array(ways.length + 1);
      if (!this.#image) this.#image = image;
      this.left = Math.ceil(side / ROWS);
      const old = this.#image;
      const jobs = Array.from({ length: this.left }, async (_, i) => {
        const part = angle.slice(i * ROWS, (i + 1) * ROWS);
        const found = await batch.run("table", "exits", { block, x, y, most: MOST, angle: part, speed });
        if (!batch.live()) return;
        part.forEach((__, a) => {
          for (let s = 0; s < side; s++) {
            const at = ways.indexOf(found.ways[a * side + s]), place = at < 0 ? ways.length : at;
            counts[place] += 1;
            const [r, g, b] = rgb(at < 0 ? theme().chaos : EXITS[at % EXITS.length]);
            image.data.set([r, g, b, 255], 4 * ((side - 1 - s) * side + i * ROWS + a));
          }
        });
        this.left -= 1;
        if (old === this.#image || this.#image === image) this.draw();
      });
      try {
        await Promise.all(jobs);
      } catch (error) {
        this.problem(`The exits could not be computed: ${error instanceof Error ? error.message : error}.`);
        return;
      }
      if (!batch.live()) return;
      this.#image = image;
      this.#side = side;
      this.shares = counts.map((n) => n / (side * side));
      this.counted();
      this.draw();
    }
  }

  get side() {
    return this.#side;
  }

  draw() {
    const { axes } = this, c = /** @type {CanvasRenderingContext2D} */ (axes.begin());
    if (this.#image) {
      const sheet = new OffscreenCanvas(this.#image.width, this.#image.height);
      /** @type {OffscreenCanvasRenderingContext2D} */ (sheet.getContext("2d")).putImageData(this.#image, 0, 0);
      c.imageSmoothingEnabled = false;
      c.drawImage(sheet, axes.box.x, axes.box.y, axes.box.w, axes.box.h);
    }
    axes.frame("launch angle", "launch speed");
    if (!this.chosen) return;
    const [angle, speed] = this.chosen, { paper, ink } = theme();
    for (const [colour, width] of /** @type {[string, number][]} */ ([[paper, 5], [ink, 2]])) {
      c.strokeStyle = colour;
      c.lineWidth = width;
      c.beginPath();
      c.arc(axes.x(angle), axes.y(speed), 7, 0, 2 * Math.PI);
      c.stroke();
    }
  }
}
