// @ts-check
/** The table edited by hand: bumpers are dragged to where there is room, and each has its own kick and bounce. */

import { distance } from "./near.js";

/** @typedef {import("./played.js").Played} Played */

/** Parts of a table's width that an arrow key moves a disc by, and pixels around a disc that still take it. */
const STEP = 1 / 200, GRASP = 10;

/** Whether a disc has room at a place: it overlaps nothing, stays on the table, and leaves launches free. @param {Played} game @param {number} j @param {number} x @param {number} y */
export function hasRoom(game, j, x, y) {
  const { things, table } = game, { radius } = things[j].shape, [x0, x1, y0, y1] = table.box;
  const free = (/** @type {number[]} */ [a, b]) => Math.hypot(x - a, y - b) > radius + table.rho;
  return x - radius >= x0 && x + radius <= x1 && y - radius >= y0 && y + radius <= y1
    && things.every((one, i) => i === j || distance(x, y, one) >= radius) && free(table.launch) && free(table.from);
}

export class Edit {
  on = false;
  /** The disc that is chosen, -1 for none. */
  chosen = -1;
  /** @type {{dx: number, dy: number} | null} where the disc under the hand was taken */ #held = null;

  /** @param {HTMLCanvasElement} canvas @param {{game: () => Played, drawing: import("./tabledraw.js").TableDraw, chose: () => void, moved: () => void}} page */
  constructor(canvas, page) {
    this.page = page;
    const at = (/** @type {PointerEvent} */ event) => [page.drawing.atX(event.offsetX), page.drawing.atY(event.offsetY)];
    canvas.addEventListener("pointerdown", (event) => {
      if (!this.on) return;
      const [x, y] = at(event), { things } = page.game(), near = this.discs.filter((j) => Math.hypot(x - things[j].shape.x, y - things[j].shape.y) < things[j].shape.radius + GRASP / page.drawing.scale);
      this.choose(near.at(-1) ?? -1);
      if (this.chosen < 0) return;
      const { shape } = things[this.chosen];
      this.#held = { dx: shape.x - x, dy: shape.y - y };
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!this.#held) return;
      const [x, y] = at(event);
      this.move(x + this.#held.dx, y + this.#held.dy);
    });
    for (const up of ["pointerup", "pointercancel"]) canvas.addEventListener(up, () => (this.#held = null));
    canvas.addEventListener("keydown", (event) => {
      const step = this.on && /** @type {Record<string, number[]>} */ ({ ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] })[event.key];
      if (step) {
        if (this.chosen < 0) this.choose(this.discs[0] ?? -1);
        const [x0, x1] = page.game().table.box, { x, y } = page.game().things[this.chosen]?.shape ?? {};
        this.move(x + step[0] * STEP * (x1 - x0), y + step[1] * STEP * (x1 - x0));
      } else if (this.on && (event.key === "[" || event.key === "]")) {
        const { discs } = this, many = discs.length;
        this.choose(discs[(discs.indexOf(this.chosen) + (event.key === "]" ? 1 : many - 1) + (this.chosen < 0 && event.key === "[" ? 1 : 0)) % many] ?? -1);
      } else return;
      event.preventDefault();
      event.stopPropagation(); // the arrows do not work the flippers
    });
  }

  /** The discs of the table. */
  get discs() {
    return this.page.game().things.flatMap(({ kind }, j) => (kind === "disc" ? [j] : []));
  }

  /** @param {boolean} on */
  turn(on) {
    this.on = on;
    this.choose(-1);
  }

  /** @param {number} j */
  choose(j) {
    this.chosen = j;
    this.page.chose();
  }

  /** Move the chosen disc to a place, if it has room there, else as far along either axis as it has. @param {number} x @param {number} y */
  move(x, y) {
    const game = this.page.game(), j = this.chosen, now = game.things[j]?.shape;
    if (!now) return;
    const place = [[x, y], [x, now.y], [now.x, y]].find(([a, b]) => hasRoom(game, j, a, b));
    if (!place) return;
    const { name } = game.things[j];
    game.set(`${name}.x`, place[0]);
    game.set(`${name}.y`, place[1]);
    this.page.moved();
  }
}
