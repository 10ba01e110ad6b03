// @ts-check
/** The zero-time discontinuity map of one state, Figure 2.1: to the wall, the reset, and back by the same time. */
import { periodColour, theme } from "./colours.js";

/** @typedef {{points: [number, number][], delta: number, acceleration: number, x: number}} ZeroTime rows (U0, V0) to (U3, V3) */

const NAMES = ["(U₀, V₀)", "(U₁, V₁)", "(U₂, V₂)", "(U₃, V₃)"];
/** Where each name stands beside its point, in pixels, and from which side. */
const PLACES = /** @type {[number, number, CanvasTextAlign][]} */ ([[9, -9, "left"], [0, 14, "center"], [-2, -12, "right"], [-10, -2, "right"]]);

/**
 * The four points for a state at the section, or null where the flight of constant acceleration does not reach the wall.
 * @param {import("./machine.js").Machine} machine @param {import("./machine.js").Floats} row @param {number} u @param {number} v
 * @returns {ZeroTime | null}
 */
export function zeroTime(machine, row, u, v) {
  const { result: x, corners, numbers: [delta, acceleration] } = machine.call("zero_time", { row, u0: u, v0: v }, ["corners", "numbers"]);
  if (Number.isNaN(x)) return null;
  return { points: [0, 2, 4, 6].map((i) => [corners[i], corners[i + 1]]), delta, acceleration, x };
}

/**
 * Draw the four points with U upwards and V to the right, the flights that join them, and the exact flow behind.
 * @param {import("./plot.js").Axes} axes @param {ZeroTime} four @param {number} sigma @param {[number, number][][]} flow pieces (u, v)
 */
export function drawZeroTime(axes, four, sigma, flow) {
  const { points, acceleration: A, delta } = four, shown = theme();
  const U = points.map(([u]) => u), V = points.map(([, v]) => v);
  const room = (/** @type {number[]} */ values, /** @type {number} */ share) => share * (Math.max(...values) - Math.min(...values)) || 0.01;
  const wide = room(V, 0.24), high = room(U, 0.3);
  axes.span(Math.min(...V) - wide, Math.max(...V) + wide, Math.min(...U) - high, Math.max(...U) + high);
  const c = axes.begin(), { box } = axes;
  const path = (/** @type {[number, number][]} */ places, /** @type {string} */ colour, /** @type {number} */ width, /** @type {number[]} */ dash) => {
    c.strokeStyle = colour;
    c.lineWidth = width;
    c.setLineDash(dash);
    c.beginPath();
    places.forEach(([u, v], i) => (i ? c.lineTo(axes.x(v), axes.y(u)) : c.moveTo(axes.x(v), axes.y(u))));
    c.stroke();
    c.setLineDash([]);
  };
  /** At constant acceleration A the path is U = U_i + (V² − V_i²)/(2A). @param {number} i @param {number} j @returns {[number, number][]} */
  const flight = (i, j) => Array.from({ length: 41 }, (_, n) => {
    const t = (delta * n) / 40 * (i ? -1 : 1);
    return [U[i] + V[i] * t + 0.5 * A * t * t, V[i] + (V[j] - V[i]) * (n / 40)];
  });
  axes.inside(() => {
    c.fillStyle = shown.wall;
    c.fillRect(box.x, axes.y(sigma), box.w, box.h);
    path([[sigma, axes.x0], [sigma, axes.x1]], shown.ink, 1, []);
    path([[axes.y0, 0], [axes.y1, 0]], shown.faint, 0.6, []);
    for (const piece of flow) path(piece, shown.faint, 1, []);
    path(flight(0, 1), periodColour(3), 2, []);
    path([points[1], points[2]], shown.graze, 1.8, [4, 2]);
    path(flight(2, 3), periodColour(2), 2.2, [8, 2]);
    c.fillStyle = shown.ink;
    for (const [u, v] of points) {
      c.beginPath();
      c.arc(axes.x(v), axes.y(u), 4, 0, 2 * Math.PI);
      c.fill();
    }
    c.textBaseline = "middle";
    const write = (/** @type {string} */ text, /** @type {number} */ x, /** @type {number} */ y, /** @type {CanvasTextAlign} */ align) => {
      c.textAlign = align;
      c.fillText(text, x, y);
    };
    NAMES.forEach((name, i) => write(name, axes.x(V[i]) + PLACES[i][0], axes.y(U[i]) + PLACES[i][1], PLACES[i][2]));
    const middle = (/** @type {number} */ i, /** @type {number} */ j) => /** @type {const} */ ([(axes.x(V[i]) + axes.x(V[j])) / 2, (axes.y(U[i]) + axes.y(U[j])) / 2]);
    const [[ax, ay], [bx, by], [cx, cy]] = [middle(0, 1), middle(1, 2), middle(2, 3)];
    c.fillStyle = shown.faint;
    write("δ", ax - 10, ay, "right");
    write("reset", bx, by + 11, "center");
    write("−δ", cx + 10, cy, "left");
  });
  axes.frame("V", "U");
}
