// @ts-check
/** The phase portrait: the orbits that starts settle on, the ball with what is just past, and the wall. */
import { theme } from "./colours.js";
import { SAMPLES } from "./flight.js";

/** Points in one stroke: longer ones take long. */
const STROKE = 400;

/** @typedef {ReturnType<typeof import("./flight.js").flown>} Flown */
/** @typedef {{flight: Flown, colour: string, thin: boolean, name: string}} Orbit what some starts settle on */

/** Stroke a flight, which leaps at the wall. @param {import("./plot.js").Axes} axes @param {import("./svg.js").Pen} c @param {Flown} flight */
function path(axes, c, { times, u, v, hits }) {
  c.beginPath();
  let hit = 0, open = false;
  for (let i = 0; i < times.length; i++) {
    while (hit < hits.length && hits[hit].t <= times[i]) {
      const wall = axes.x(hits[hit].place);
      if (open) c.lineTo(wall, axes.y(hits[hit].before));
      c.moveTo(wall, axes.y(hits[hit].after));
      hit++;
    }
    const place = [axes.x(u[i]), axes.y(v[i])];
    if (open && i % STROKE === 0) {
      c.lineTo(place[0], place[1]);
      c.stroke();
      c.beginPath();
      open = false;
    }
    open ? c.lineTo(place[0], place[1]) : c.moveTo(place[0], place[1]);
    open = true;
  }
  c.stroke();
}

/**
 * Draw a portrait.
 * @param {import("./plot.js").Axes} axes
 * @param {{low: number, high: number, orbits: Orbit[], colour: string, trail: ([number, number] | null)[], place: [number, number], flash: (import("./flight.js").Hit & {at: number})[], playing: boolean, twin: number[] | null, aim: import("./sling.js").Aim | null}} scene
 */
export function portrait(axes, { low, high, orbits, colour, trail, place: [u, v], flash, playing, twin, aim }) {
  const c = axes.begin();
  const shown = theme();
  const { x: left, y: top, w, h } = axes.box, faces = [Math.max(axes.x(low), left - 9), Math.min(axes.x(high), left + w + 9)]; // one that is not seen is beside
  axes.inside(() => {
    c.fillStyle = shown.wall;
    c.fillRect(left - 9, top, faces[0] - left + 9, h);
    c.fillRect(faces[1], top, left + w + 9 - faces[1], h);
    c.strokeStyle = shown.line;
    c.beginPath();
    c.moveTo(axes.box.x, axes.y(0));
    c.lineTo(axes.box.x + axes.box.w, axes.y(0));
    c.stroke();
    c.globalAlpha = 0.45;
    for (const orbit of orbits) {
      c.lineWidth = orbit.thin ? 0.7 : 1.8;
      c.strokeStyle = orbit.colour;
      path(axes, c, orbit.flight);
    }
    c.globalAlpha = 1;
    c.lineWidth = 2;
    c.strokeStyle = colour;
    const tail = trail.slice(-1.2 * SAMPLES);
    for (let i = 1; i < tail.length; i++) {
      const from = tail[i - 1], to = tail[i];
      if (!from || !to) continue;
      c.globalAlpha = i / tail.length;
      c.beginPath();
      c.moveTo(axes.x(from[0]), axes.y(from[1]));
      c.lineTo(axes.x(to[0]), axes.y(to[1]));
      c.stroke();
    }
    c.globalAlpha = 1;
  });
  axes.inside(() => {
    // the bumper, and the impacts of the last moment
    c.fillStyle = shown.faint;
    c.fillRect(faces[0] - 3, top, 3, h);
    if (Number.isFinite(high)) c.fillRect(faces[1], top, 3, h);
    const now = performance.now();
    for (const each of flash) {
      const age = (now - each.at) / 600, wall = axes.x(each.place);
      if (age > 1 && playing) continue;
      c.globalAlpha = playing ? 1 - age : 0.8;
      c.strokeStyle = c.fillStyle = shown.graze;
      c.lineWidth = 2;
      for (const velocity of [each.before, each.after]) {
        c.beginPath();
        c.arc(wall, axes.y(velocity), 4 + (playing ? 10 * age : 0), 0, 7);
        c.stroke();
      }
      c.setLineDash([3, 3]);
      c.beginPath();
      c.moveTo(wall, axes.y(each.before));
      c.lineTo(wall, axes.y(each.after));
      c.stroke();
      c.setLineDash([]);
      if (age < 0.4 && playing) c.fillRect(each.wall ? faces[1] : faces[0] - 5, top, 5, h);
      c.globalAlpha = 1;
    }
    if (aim) {
      c.strokeStyle = shown.accent;
      c.lineWidth = 2;
      c.setLineDash([5, 4]);
      path(axes, c, aim.flight);
      c.setLineDash([]);
    }
    c.fillStyle = aim ? shown.accent : colour;
    c.beginPath();
    c.arc(axes.x(aim ? aim.u : u), axes.y(aim ? aim.v : v), aim ? 8 : 5, 0, 7);
    c.fill();
    if (twin && !aim) {
      c.strokeStyle = shown.accent;
      c.lineWidth = 2.5;
      c.beginPath();
      c.arc(axes.x(twin[0]), axes.y(twin[1]), 5, 0, 7);
      c.stroke();
    }
  });
  axes.frame("u", "v");
  named(axes, c, orbits);
}

/** The orbits by their names, above the picture, each with the starts that settle on it. @param {import("./plot.js").Axes} axes @param {import("./svg.js").Pen} c @param {Orbit[]} orbits */
function named(axes, c, orbits) {
  c.textAlign = "left";
  c.textBaseline = "middle";
  const size = (/** @type {string} */ text) => c.measureText(text).width, { x, w } = axes.box;
  const tight = orbits.length > 0 && 24 + size(orbits[0].name) > w - size("… of 16 starts"); // then the names alone
  const rest = tight ? "" : "of 16 starts", end = x + w - size(`… ${rest}`);
  let left = x, more = "";
  for (const { name, colour } of orbits) {
    const wide = size(name);
    if (left + 24 + wide > end) {
      more = "… ";
      break;
    }
    c.fillStyle = colour;
    c.fillRect(left, axes.box.y - 14, 11, 11);
    c.fillStyle = theme().ink;
    c.fillText(name, left + 16, axes.box.y - 8);
    left += 34 + wide;
  }
  c.fillStyle = theme().faint;
  if (orbits.length) c.fillText(more + rest, Math.max(axes.box.x, left - 12), axes.box.y - 8);
}
