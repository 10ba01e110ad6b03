// @ts-check
/** The ball above its bumper, as the pen of a chart recorder: u over time, the word of impacts, and the force. */
import { faded, theme } from "./colours.js";
import { Past } from "./past.js";
import { Axes, enlarged } from "./plot.js";
import { numeral } from "./state.js";
import { moved, swing } from "./walls.js";

/**
 * What is drawn: what is past, the turn of the forcing now, where letters begin in a turn, the ball, and the force at a turn; while the
 * ball is aimed, that in their place: the flight that begins at the turn `begins`, of `T` a turn.
 * @typedef {{past: Past, turn: number, section: number, u: number, walls: import("./walls.js").Walls & {law: string, V: number}, top: number, force: (turn: number) => number, colour: string, live: boolean, said: string, twin: import("./twin.js").Twin | null, T: number, begins: number, aim: import("./sling.js").Aim | null, hops: boolean}} Scene
 */

/** Pixels of a turn of the forcing, at least; room at the right of the pen; the ball; rows below the bumper. */
const TURN = 84, RIGHT = 108, BALL = 17, WORD = 46, FORCE = 40, CEILING = 12;
/** Turns of the forcing that are seen at least and at most: those remembered. */
const LEAST = 0.5, MOST = 9;
/** Turns that are seen while impacts are stepped through that follow one another closely. */
const HOPS = 1.5;
/** A height of the picture that has no room for the force. */
const LOW = 240;
/** What is left in the next frame of room that is no more needed. */
const SETTLES = 0.9;
/** Milliseconds for which an impact flashes. */
const FLASH = 700;
const FONT = "system-ui, sans-serif";

export class Strip {
  /** Where the ball was drawn last, in CSS pixels. */ ball = [0, 0];
  /** How high the picture reached last. */ #top = 0;
  /** Turns of the forcing that a hand has asked for, 0 for as many as there is room for. */ #turned = 0;

  /** @param {HTMLElement | null} canvas */
  constructor(canvas) {
    this.axes = new Axes(canvas, { left: 0, right: RIGHT, top: 30 + BALL });
  }

  /** Show so many turns of the forcing. @param {number} turns 0 for as many as there is room for @param {() => void} redraw */
  look(turns, redraw) {
    this.#turned = turns && Math.min(Math.max(turns, LEAST), MOST);
    redraw();
  }

  /** @param {Scene} given */
  draw(given) {
    const { axes } = this, low = axes.canvas.clientHeight / enlarged() < LOW;
    axes.margin.bottom = WORD + BALL + (low ? 8 : FORCE + 22);
    const c = axes.begin(), { box } = axes, shown = theme(), { aim } = given;
    const scene = aim ? { ...given, past: new Past(), turn: given.begins, u: aim.u } : given;
    const turns = this.#turned || (scene.hops ? HOPS : Math.max(2, Math.min(8, box.w / TURN))), last = aim ? scene.turn + turns * (1 - ((aim.pen ?? box.x + 0.2 * box.w) - box.x) / box.w) : scene.turn;
    const bottom = scene.walls.sigma - swing(scene.walls), top = this.#reach(scene, last - turns);
    // under a ceiling there is room for it and for the ball
    const above = scene.walls.two ? (CEILING / Math.max(1, box.h - CEILING)) * (top - bottom) : 0;
    axes.span(last - turns, last, bottom, top + above);
    const width = box.w + RIGHT, floor = box.y + box.h + BALL;
    if (!aim) this.#turns(c, scene, floor, low && Boolean(scene.twin));
    this.#bumper(c, scene, width, floor, low && Boolean(scene.twin && !aim));
    this.#marks(c, scene);
    if (scene.twin && !aim) this.#line(c, { ...scene, past: scene.twin.past, colour: shown.accent }, 1.6);
    this.#line(c, scene);
    this.#force(c, scene, floor + WORD, low || Boolean(scene.twin && !aim));
    if (scene.twin && !aim) this.#distance(c, scene.twin, low ? floor + 6 : floor + WORD + 12, low ? WORD - 6 : FORCE);
    if (aim) this.#ahead(c, scene, aim);
    this.#ball(c, scene);
    if (scene.twin && !aim) this.#twin(c, scene.twin);
    c.font = `15px ${FONT}`;
    c.fillStyle = shown.faint;
    c.textAlign = "left";
    c.textBaseline = "top";
    c.fillText("height u", 14, 9);
    c.textAlign = "right";
    const said = aim ? `begins at u = ${numeral(aim.u, 3)}, v = ${numeral(aim.v, 3)}` : scene.said, wide = c.measureText(said).width;
    c.fillStyle = faded(shown.paper, 0.8); // the arrow of the force may reach there
    c.fillRect(width - 16 - wide, 5, wide + 8, 22);
    c.fillStyle = shown.faint;
    c.fillText(said, width - 12, 9);
  }

  /** The letters of the word, one for each turn. @param {import("./svg.js").Pen} c @param {Scene} scene @param {number} floor @param {boolean} bare whether there is room for lines only */
  #turns(c, { past, turn, section, colour }, floor, bare) {
    const { axes } = this, shown = theme();
    for (let n = Math.floor(axes.x0 - section); n <= Math.floor(turn - section); n++) {
      const x = axes.x(n + section), middle = Math.min(axes.x(n + section + 0.5), axes.x(turn)), letter = past.letters.get(n);
      c.fillStyle = shown.line;
      if (x >= 0) c.fillRect(x, axes.box.y, 1, floor - axes.box.y);
      if (letter === undefined || middle < 12 || bare) continue;
      c.fillStyle = letter === 0 ? shown.faint : colour;
      const said = String(letter).length > 1 ? `(${letter})` : String(letter), font = (/** @type {number} */ size) => (c.font = `700 ${size}px ui-monospace, Menlo, Consolas, monospace`);
      font(letter === 0 ? 24 : 28);
      const wide = c.measureText(said).width, room = 0.94 * (axes.x(1) - axes.x(0));
      if (wide > room) font(Math.max(11, (28 * room) / wide));
      c.textAlign = "center";
      c.textBaseline = "middle";
      c.fillText(said, middle, floor + 7 + WORD / 2);
    }
  }

  /** @param {import("./svg.js").Pen} c @param {Scene} scene @param {number} width @param {number} floor @param {boolean} bare */
  #bumper(c, { past, turn, live, walls, T }, width, floor, bare) {
    const { axes } = this, shown = theme();
    c.lineWidth = 7;
    for (const [wall, height, off] of [[0, walls.sigma, BALL + 3.5], ...(walls.two ? [[1, walls.sigma_B, -BALL - 3.5]] : [])]) {
      const last = past.marks.findLast((mark) => mark.wall === wall), age = last ? (performance.now() - last.at) / FLASH : 2;
      for (const [colour, from, to] of /** @type {[string, number, number][]} */ ([[shown.faint, 0, width], [faded(shown.graze, live ? Math.max(0.35, 1 - age) : 0.35), axes.x(turn) - 52, axes.x(turn) + 52]])) {
        const steps = swing(walls) ? Math.ceil((to - from) / 4) : 1;
        c.strokeStyle = colour;
        c.beginPath();
        for (let i = 0; i <= steps; i++) {
          const x = from + ((to - from) * i) / steps, y = axes.y(height + moved(walls, axes.atX(x) * T)[0]) + off;
          i ? c.lineTo(x, y) : c.moveTo(x, y);
        }
        c.stroke();
      }
    }
    c.fillStyle = shown.graze;
    c.font = `15px ${FONT}`;
    c.textAlign = "right";
    c.textBaseline = "middle";
    c.fillText(walls.law !== "newton" && walls.V > 0 ? "bumper" : "wall", width - 12, floor - 10);
    c.fillStyle = shown.faint;
    if (!bare) c.fillText("word", width - 12, floor + 7 + WORD / 2);
  }

  /** The logarithm of the distance of the twin: it grows along a line, until balls are as far apart as they can be. @param {import("./svg.js").Pen} c @param {import("./twin.js").Twin} twin @param {number} above @param {number} high */
  #distance(c, { distances }, above, high) {
    const { axes } = this, shown = distances.filter(([turn]) => turn >= axes.x0), logs = shown.map(([, log]) => log), [low, most] = [Math.min(...logs, -5), Math.max(...logs, 0)];
    c.strokeStyle = c.fillStyle = theme().accent;
    c.lineWidth = 2;
    c.beginPath();
    shown.forEach(([turn, log], i) => c[i ? "lineTo" : "moveTo"](axes.x(turn), above + ((most - log) / (most - low)) * high));
    c.stroke();
    c.font = `15px ${FONT}`;
    c.textAlign = "right";
    c.textBaseline = "middle";
    c.fillText("ln distance", axes.box.x + axes.box.w + RIGHT - 12, above + high / 2);
  }

  /** How high the picture reaches: a flight higher than those of now is seen until it has left, and then the rest grows into its room. @param {Scene} scene @param {number} from the turn at the left */
  #reach({ past, top, u, live }, from) {
    const wanted = past.line.reduce((most, point) => (point && point.turn >= from ? Math.max(most, point.u) : most), Math.max(top, u));
    return (this.#top = live && wanted < this.#top ? wanted + (this.#top - wanted) * SETTLES : wanted);
  }

  /** The curve, fainter the longer ago. @param {import("./svg.js").Pen} c @param {Scene} scene */
  #line(c, { past, turn, colour }, width = 3) {
    const { axes } = this;
    c.lineWidth = width;
    const { line } = past, span = axes.x1 - axes.x0, first = line.findIndex((point) => point && point.turn >= axes.x0);
    if (first < 0) return;
    /** @type {typeof line[number]} */
    let before = null;
    let stroke = -1;
    for (const point of line.slice(Math.max(0, first - 1))) {
      const piece = point ? Math.floor(((turn - point.turn) / span) * 12) : -1;
      if (piece !== stroke || !point) {
        if (before) c.stroke();
        c.beginPath();
        if (before) c.moveTo(axes.x(before.turn), axes.y(before.u));
        else if (point) c.moveTo(axes.x(point.turn), axes.y(point.u));
        c.strokeStyle = faded(colour, Math.min(1, Math.max(0.15, 1 - piece / 13)));
        stroke = piece;
      }
      if (point) c.lineTo(axes.x(point.turn), axes.y(point.u));
      before = point;
    }
    if (before) c.stroke();
  }

  /** Impacts, which flash. @param {import("./svg.js").Pen} c @param {Scene} scene */
  #marks(c, { past, live }) {
    const { axes } = this, now = performance.now();
    c.fillStyle = c.strokeStyle = theme().graze;
    const lasts = [-Infinity, -Infinity];
    for (const mark of past.marks) {
      const x = axes.x(mark.turn), side = mark.wall ? -1 : 1, y = axes.y(mark.place) + side * (BALL - 1), age = live ? (now - mark.at) / FLASH : 2;
      if (x < Math.max(4, lasts[mark.wall] + 2)) continue; // impacts that cannot be told apart are one mark
      lasts[mark.wall] = x;
      c.beginPath();
      c.arc(x, y, 5, 0, 7);
      c.fill();
      c.lineWidth = 2;
      for (const [i, radius] of [12, 21, 30].entries()) {
        c.strokeStyle = faded(theme().graze, age < 1 ? (1 - age) * (1 - i / 4) : 0.25 - i / 14);
        c.beginPath();
        c.arc(x, y, radius + (age < 1 ? 8 * age : 0), side < 0 ? 0.74 : -2.4, side < 0 ? 2.4 : -0.74);
        c.stroke();
      }
    }
  }

  /** The force up to now, where there is room for it, and its arrow at the ball. @param {import("./svg.js").Pen} c @param {Scene} scene @param {number} above */
  #force(c, { turn, force, u }, above, low = false) {
    const { axes } = this, shown = theme(), steps = 160;
    const values = Array.from({ length: steps + 1 }, (_, i) => force(axes.x0 + (i / steps) * (axes.x1 - axes.x0)));
    const most = Math.max(...values.map(Math.abs), 1e-300), middle = above + 12 + FORCE / 2;
    c.strokeStyle = c.fillStyle = shown.faint;
    if (!low) {
      c.lineWidth = 1.6;
      c.beginPath();
      values.forEach((value, i) => {
        const x = axes.box.x + (i / steps) * axes.box.w, y = middle - (value / most) * (FORCE / 2 - 4);
        if (i) c.lineTo(x, y);
        else c.moveTo(x, y);
      });
      c.stroke();
      c.font = `15px ${FONT}`;
      c.textAlign = "right";
      c.textBaseline = "middle";
      c.fillText("force", axes.box.x + axes.box.w + RIGHT - 12, middle);
    }
    const push = (force(turn) / most) * 44, x = axes.x(turn) + 26, y = axes.y(u);
    if (Math.abs(push) < 3) return;
    const side = Math.sign(push);
    c.lineWidth = 3;
    c.beginPath();
    c.moveTo(x, y);
    c.lineTo(x, y - push);
    c.moveTo(x - 6, y - push + side * 8);
    c.lineTo(x, y - push);
    c.lineTo(x + 6, y - push + side * 8);
    c.stroke();
  }

  /** The flight that is foreseen, and where it begins. @param {import("./svg.js").Pen} c @param {Scene} scene @param {import("./sling.js").Aim} aim */
  #ahead(c, { turn, T, colour }, { flight }) {
    const { axes } = this, { times, hits } = flight;
    c.strokeStyle = colour;
    c.lineWidth = 2.5;
    c.setLineDash([7, 5]);
    c.beginPath();
    let hit = 0;
    for (let i = 0; i < times.length; i++) {
      while (hit < hits.length && hits[hit].t <= times[i]) c.lineTo(axes.x(turn + hits[hit].t / T), axes.y(hits[hit++].place));
      const [x, y] = [axes.x(turn + times[i] / T), axes.y(flight.u[i])];
      i ? c.lineTo(x, y) : c.moveTo(x, y);
    }
    c.stroke();
    c.setLineDash([]);
    c.fillStyle = theme().graze;
    for (const { t, wall, place } of hits) {
      c.beginPath();
      c.arc(axes.x(turn + t / T), axes.y(place) + (wall ? 1 - BALL : BALL - 1), 5, 0, 7);
      c.fill();
    }
  }

  /** @param {import("./svg.js").Pen} c @param {import("./twin.js").Twin} twin */
  #twin(c, { place, flight, clock }) {
    if (!flight) return;
    c.strokeStyle = theme().accent;
    c.lineWidth = 2.5;
    c.beginPath();
    c.arc(this.axes.x(clock(flight.now)), this.axes.y(place[0]), BALL - 1, 0, 7);
    c.stroke();
  }

  /** @param {import("./svg.js").Pen} c @param {Scene} scene */
  #ball(c, { turn, u, colour, hops }) {
    const { axes } = this, x = axes.x(turn), y = axes.y(u);
    this.ball = [x, y];
    c.fillStyle = hops ? faded(colour, 0.15) : colour;
    c.strokeStyle = colour;
    c.lineWidth = 2;
    c.beginPath();
    c.arc(x, y, BALL, 0, 7);
    c.fill();
    if (hops) c.stroke(); // the last hops are seen through it
    c.fillStyle = faded(colour, 0.4);
    c.beginPath();
    c.arc(x - 6, y - 6, 4, 0, 7);
    c.fill();
  }
}
