// @ts-check
/** The walls: one below the ball, or two, which may move together. */

import { kicks } from "./laws.js";

/** What of a state says where they are. @typedef {{two: boolean | number, sigma: number, sigma_B: number, cos_A: number, sin_A: number, omega: number, t0: number}} Walls */

/** Walls come no nearer to each other. */
export const ROOM = 0.02;

/** Whether there is one wall, at rest. @param {Walls} walls */
export const still = ({ two, cos_A, sin_A }) => !two && cos_A === 0 && sin_A === 0;

/** How far walls move to each side. @param {Walls} walls */
export const swing = ({ cos_A, sin_A }) => Math.hypot(cos_A, sin_A);

/** How far walls are from their middle at a time, and how fast they move. @param {Walls} walls @param {number} t @returns {[number, number]} */
export function moved({ cos_A, sin_A, omega, t0 }, t) {
  const c = Math.cos(omega * (t + t0)), s = Math.sin(omega * (t + t0));
  return [cos_A * c + sin_A * s, omega * (sin_A * c - cos_A * s)];
}

/** Where the upper wall is in the middle; without one nothing is too high. @param {Walls} walls */
export const ceiling = ({ two, sigma_B }) => (two ? sigma_B : Infinity);

/**
 * How often a ball hits walls in a period, about. Between two it crosses the room as fast as kicks and bounces make it, or the force
 * alone, and the walls come towards it by four swings; against one that kicks spring and force press it again and again.
 * @param {Walls & {law: string, k: number, offset: number, r: number, r_B: number, V: number, V_B: number, cos1: number, sin1: number}} state
 */
export function crossings(state) {
  const { two, sigma, sigma_B, omega, law, k, offset, r, r_B, V, V_B, cos1, sin1 } = state, kick = kicks({ law, V, V_B });
  if (!two) return kick.below ? Math.max(0, (Math.PI / omega) * (k * k * sigma - offset + Math.hypot(cos1, sin1)) * ((1 - r) / V)) : 0;
  const kicked = (Number(kick.below) * V * (1 + r_B) + Number(kick.above) * V_B * (1 + r)) / (2 * Math.max(1 - r * r_B, 0.05));
  return (((2 * Math.PI) / omega) * Math.max(kicked, Math.hypot(cos1, sin1) / omega / 2) + 4 * swing(state)) / Math.max(sigma_B - sigma, ROOM);
}

/** A position that is not behind a wall at a time: the nearest one. @param {Walls} walls @param {number} u @param {number} t */
export function inside(walls, u, t) {
  const [at] = moved(walls, t);
  return Math.min(Math.max(u, walls.sigma + at), ceiling(walls) + at);
}

/** The walls of a row of parameters. @param {string[]} fields @param {ArrayLike<number>} row @returns {Walls} */
export const wallsOf = (fields, row) => /** @type {any} */ (Object.fromEntries(["two", "sigma", "sigma_B", "cos_A", "sin_A", "omega", "t0"].map((name) => [name, row[fields.indexOf(name)]])));
