// @ts-check
/** Through which drain a ball leaves, over the angle and speed of its launch: a picture that gets finer, to be clicked. */
import { theme, rgb } from "./colours.js";
import { Gestures } from "./gestures.js";
import { linspace } from "./jobs.js";
import { Axes } from "./plot.js";
import { EXITS } from "./tabledraw.js";

/** @typedef {import("./played.js").Played} Played */

/** Sides of a picture, coarse first. */
export const SIDES = [40, 160, 320];
/** Rows of one job; impacts after which a launch is given up; how far a picture is zoomed. */
const ROWS = 8, MOST = 1500, LEAST = 1e-9;
/** Names of launches by their impacts, where all balls go away. */
const COUNTED = [...EXITS.keys()].map((n) => (n === EXITS.length - 1 ? `${n} or more hits` : `${n || "no"} hit${n === 1 ? "" : "s"}`));

/** @typedef {[number, number]} Pair */

export class Exits {
  /** @type {{image: ImageData, ends: number[]} | null} a picture, and where it lies */ #seen = null;
  #side = 0;
  /** @type {Pair | null} the launch that was chosen: angle, and speed or height */ chosen = null;
  /** @type {Pair[]} all angles, and all speeds or heights */ #whole = [];
  key = "";
  /** Rows that are still to come at this side. */
  left = 0;

  /** @param {HTMLCanvasElement} canvas @param {import("./pool.js").Pool} pool @param {() => void} counted what is done when shares are known, coarse or fine @param {(state: import("./played.js").State) => void} launch @param {(text: string) => void} problem */
  constructor(canvas, pool, counted, launch, problem) {
    this.axes = new Axes(canvas, { top: 30 });
    this.pool = pool;
    this.counted = counted;
    this.problem = problem;
    /** @type {(angle: number, up: number) => void} */
    this.choose = (angle, up) => {
      const { x, y, speed } = this.#from(up);
      this.chosen = [angle, up];
      launch([x, y, speed * Math.cos(angle), speed * Math.sin(angle)]);
      this.draw();
    };
    const shown = (/** @type {Pair} */ across, /** @type {Pair} */ up) => {
      const ends = [across, up].map(([low, high], i) => [Math.max(low, this.#whole[i][0]), Math.min(high, this.#whole[i][1])]);
      if (!this.game || ends.some(([low, high], i) => !(high - low > LEAST * (this.#whole[i][1] - this.#whole[i][0])))) return;
      this.axes.span(ends[0][0], ends[0][1], ends[1][0], ends[1][1]);
      this.show(this.game);
    };
    this.gestures = new Gestures(this.axes, {
      ready: () => Boolean(this.game),
      redraw: () => this.draw(),
      pick: (angle, up) => {
        this.choose(angle, up);
        return () => {};
      },
      zoom: (across, up) => up && shown(across, up),
      zoomOut: () => this.home && shown([this.home[0], this.home[1]], [this.home[2], this.home[3]]),
      chosen: () => this.chosen ?? [(this.axes.x0 + this.axes.x1) / 2, (this.axes.y0 + this.axes.y1) / 2],
      steps: () => [200, 200],
    });
  }

  /** Begin with the launches of a rung. @param {Played} game @param {import("./rungs.js").Rung} rung */
  begin(game, { heights, home }) {
    this.heights = heights;
    this.#whole = [[0, 2 * Math.PI], heights ?? [0, game.table.from[2]]];
    this.home = home ?? this.#whole.flat();
    this.chosen = null;
    if (game.table !== this.game?.table) {
      // nothing of another table
      this.#seen = null;
      this.shares = undefined;
      this.counted();
    }
    this.axes.span(this.home[0], this.home[1], this.home[2], this.home[3]);
    this.show(game);
  }

  /** Where a ball is launched, and how fast. @param {number} up */
  #from(up) {
    const [x, y, fastest] = /** @type {Played} */ (this.game).table.from;
    return this.heights ? { x, y: up, speed: fastest } : { x, y, speed: up };
  }

  /** Show the exits of a table as it is now, flippers at rest. @param {Played} game */
  async show(game) {
    const { table } = game, { x0, x1, y0, y1 } = this.axes, ends = [x0, x1, y0, y1], key = JSON.stringify([table.params.length, table.box, game.values, ends]);
    this.game = game;
    if (key === this.key) return this.draw();
    this.key = key;
    this.draw();
    const batch = this.pool.batch("exits"), { heights } = this;
    const ways = table.objects.flatMap((one, j) => (one.kind === "drain" ? [j] : []));
    this.names = ways.length ? [...ways.map((j) => table.objects[j].name), "stays or goes away"] : COUNTED;
    this.shares = new Float64Array(this.names.length);
    const block = game.atRest;
    for (const side of SIDES) {
      const angle = linspace(x0, x1, side), up = linspace(y0, y1, side), many = heights ? 1 : ROWS;
      const image = new ImageData(side, side), counts = new Float64Array(this.names.length), seen = { image, ends };
      if (!this.#seen) this.#seen = seen;
      this.left = Math.ceil(side / many);
      const old = this.#seen;
      const jobs = Array.from({ length: this.left }, async (_, i) => {
        // balls of one height at all angles, or of some angles at all speeds
        const { x, y, speed } = this.#from(up[i]), part = heights ? angle : angle.slice(i * ROWS, (i + 1) * ROWS), speeds = heights ? Float64Array.of(speed) : up;
        const found = await batch.run("table", "exits", { block, x, y, most: MOST, angle: part, speed: speeds });
        if (!batch.live()) return;
        for (let n = 0; n < part.length * speeds.length; n++) {
          const [a, s] = heights ? [n, i] : [i * ROWS + Math.floor(n / side), n % side], at = ways.indexOf(found.ways[n]);
          const place = !ways.length ? Math.min(found.hits[n], COUNTED.length - 1) : at < 0 ? ways.length : at;
          counts[place] += 1;
          image.data.set([...rgb(this.colour(place)), 255], 4 * ((side - 1 - s) * side + a));
        }
        this.left -= 1;
        if (old === this.#seen || this.#seen === seen) this.draw();
      });
      try {
        await Promise.all(jobs);
      } catch (error) {
        this.problem(`The exits could not be computed: ${error instanceof Error ? error.message : error}.`);
        return;
      }
      if (!batch.live()) return;
      this.#seen = seen;
      this.#side = side;
      this.shares = counts.map((n) => n / (side * side));
      this.counted();
      this.draw();
    }
  }

  /** The colour of a way. @param {number} place */
  colour(place) {
    return this.names !== COUNTED && place === (this.names?.length ?? 0) - 1 ? theme().chaos : EXITS[place % EXITS.length];
  }

  get side() {
    return this.#side;
  }

  draw() {
    const { axes } = this, c = /** @type {CanvasRenderingContext2D} */ (axes.begin());
    if (this.#seen) {
      const { image, ends: [x0, x1, y0, y1] } = this.#seen, sheet = new OffscreenCanvas(image.width, image.height);
      /** @type {OffscreenCanvasRenderingContext2D} */ (sheet.getContext("2d")).putImageData(image, 0, 0);
      c.imageSmoothingEnabled = false;
      axes.inside(() => c.drawImage(sheet, axes.x(x0), axes.y(y1), axes.x(x1) - axes.x(x0), axes.y(y0) - axes.y(y1)));
    }
    axes.frame("launch angle, rad", this.heights ? "launch height" : "launch speed");
    this.gestures.draw(c);
    if (!this.chosen) return;
    const [angle, speed] = this.chosen, { paper, ink } = theme();
    if (angle < axes.x0 || angle > axes.x1 || speed < axes.y0 || speed > axes.y1) return;
    for (const [colour, width] of /** @type {[string, number][]} */ ([[paper, 5], [ink, 2]])) {
      c.strokeStyle = colour;
      c.lineWidth = width;
      c.beginPath();
      c.arc(axes.x(angle), axes.y(speed), 7, 0, 2 * Math.PI);
      c.stroke();
    }
  }
}
