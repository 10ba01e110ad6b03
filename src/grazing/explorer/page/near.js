// @ts-check
/** How near a ball comes to what stands on a table: for places that are free, and for what is missed by a hair. */

/** @typedef {import("./played.js").Played} Played */
/** @typedef {import("./played.js").Thing} Thing */

/** Seconds of a flight that are looked back on, looks at them, and steps that each narrow the nearest one. */
const BACK = 0.4, LOOKS = 24, NARROWED = 40;

/** How far a point is from a line between two others. @param {number} x @param {number} y @param {Record<string, number>} line */
function fromLine(x, y, { x1, y1, x2, y2 }) {
  const [ex, ey] = [x2 - x1, y2 - y1], along = Math.min(1, Math.max(0, ((x - x1) * ex + (y - y1) * ey) / (ex * ex + ey * ey)));
  return Math.hypot(x - x1 - along * ex, y - y1 - along * ey);
}

/** How far a point is from a flipper whose tip is at an angle, seen from its pivot. @param {number} dx @param {number} dy @param {Record<string, number>} shape @param {number} angle */
function fromFlipper(dx, dy, { length, hub, tip }, angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)], along = dx * c + dy * s, beside = Math.abs(dy * c - dx * s);
  const sine = (hub - tip) / length, cosine = Math.sqrt((1 - sine) * (1 + sine)), foot = along * cosine - beside * sine;
  if (foot <= 0) return Math.hypot(along, beside) - hub;
  if (foot >= length * cosine) return Math.hypot(along - length, beside) - tip;
  return along * sine + beside * cosine - hub;
}

/** How far a point is from an object; of a flipper, from where it is at an angle, else from all places that it reaches. @param {number} x @param {number} y @param {Thing} one @param {number} [angle] */
export function distance(x, y, { kind, shape }, angle) {
  if (kind === "segment" || kind === "drain") return fromLine(x, y, shape);
  const [dx, dy] = [x - shape.x, y - shape.y], far = Math.hypot(dx, dy);
  if (kind === "disc") return far - shape.radius;
  if (kind === "flipper") return angle === undefined ? far - shape.length - Math.max(shape.hub, shape.tip) : fromFlipper(dx, dy, shape, angle);
  const turn = (((Math.atan2(dy, dx) - shape.start) % (2 * Math.PI)) + 2 * Math.PI) % (2 * Math.PI);
  if (turn <= shape.stop - shape.start) return Math.abs(far - shape.radius);
  return Math.min(...[shape.start, shape.stop].map((a) => Math.hypot(dx - shape.radius * Math.cos(a), dy - shape.radius * Math.sin(a))));
}

/** By how much the flight under way has missed an object, if it has just come near it and gone again; else Infinity. @param {Played} game @param {number} j */
export function missedBy(game, j) {
  const { state: [x, y, vx, vy], begin, length } = game.flight, one = game.things[j], g = game.block[game.layout.GRAVITY];
  const off = (/** @type {number} */ t) => distance(x + vx * t, y + (vy - 0.5 * g * t) * t, one, one.kind === "flipper" ? game.angle(one.name, begin + t) : 0) - game.table.rho;
  const from = Math.max(0, length - BACK), step = (length - from) / LOOKS, seen = Array.from({ length: LOOKS + 1 }, (_, i) => off(from + step * i));
  const at = seen.indexOf(Math.min(...seen));
  if (at === 0 || at === LOOKS) return Infinity; // it comes from there, or still comes nearer
  let [low, high] = [from + step * (at - 1), from + step * (at + 1)];
  for (let i = 0; i < NARROWED; i++) {
    const third = (high - low) / 3;
    if (off(low + third) < off(high - third)) high -= third;
    else low += third;
  }
  return off((low + high) / 2);
}
