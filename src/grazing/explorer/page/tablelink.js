// @ts-check
/** A game as a link and as a program: the table, what was changed on it, the launch, and what the player did. */

import { Played } from "./played.js";

/** @typedef {import("./played.js").State} State */
/** @typedef {{table: string, changes: Record<string, number>, start: State | null, presses: Record<string, number[]>, nudges: import("./played.js").Nudge[], note: string}} Linked */

/** Of the form of a link; letters of its note. */
const VERSION = 1, LONGEST_NOTE = 280;
/** Seconds after the end of a game up to which Python follows it: times of parts are added up in another order. */
const BEYOND = 1e-6;

/** @param {string} table @param {Played} game */
export function toLink(table, game) {
  const given = new URLSearchParams({ v: String(VERSION), table });
  for (const [name, value] of Object.entries(game.changes)) given.set(name, String(value));
  if (game.t > 0 && !game.changed) {
    given.set("start", game.start.join(","));
    for (const [name, times] of Object.entries(game.presses)) if (times.length) given.set(`${name}.pressed`, times.join(","));
    if (game.nudges.length) given.set("nudges", game.nudges.flatMap(({ t, state }) => [t, ...state]).join(","));
  }
  return `#${given}`;
}

/** @param {string} text @param {string} what */
function numbers(text, what) {
  const found = text.split(",").map((word) => (word.trim() ? Number(word) : NaN)); // of nothing, Number makes 0
  if (!found.every(Number.isFinite)) throw new Error(`${what} is ${text.slice(0, 40)}, which are no numbers`);
  return found;
}

/** @param {string} hash @param {Record<string, import("./played.js").Table>} tables @returns {Linked | null} */
export function fromLink(hash, tables) {
  if (hash.length < 2) return null;
  const given = new URLSearchParams(hash.slice(1)), table = given.get("table") ?? "";
  if (Number(given.get("v")) > VERSION) throw new Error("it was made by a newer version of the page");
  if (!Object.hasOwn(tables, table)) throw new Error(table ? `there is no table ${table.slice(0, 40)}` : "it names no table");
  const { params, objects } = tables[table], names = [...given.keys()], twice = names.find((name, i) => names.indexOf(name) < i);
  if (twice) throw new Error(`${twice.slice(0, 40)} is given twice`);
  /** @type {Linked} */
  const found = { table, changes: {}, start: null, presses: {}, nudges: [], note: (given.get("note") ?? "").slice(0, LONGEST_NOTE) };
  for (const [name, text] of given) {
    const flipper = objects.find((one) => one.kind === "flipper" && name === `${one.name}.pressed`);
    if (params.includes(name)) {
      if (!Played.canSet(tables[table], name)) throw new Error(`${name} cannot be changed on this page`);
      [found.changes[name]] = numbers(text, name);
      if (name.endsWith(".r") && !(found.changes[name] >= 0 && found.changes[name] <= 1)) throw new Error(`${name} is ${text.slice(0, 40)}; it goes from 0 to 1`);
      if (name.endsWith(".V") && !(found.changes[name] >= 0)) throw new Error(`${name} is ${text.slice(0, 40)}; it is 0 or more`);
    } else if (name === "start") {
      const start = numbers(text, name);
      if (start.length !== 4) throw new Error("start needs four numbers: x, y and the velocity");
      found.start = /** @type {State} */ (start);
    } else if (name === "nudges") {
      const all = numbers(text, name);
      if (all.length % 5) throw new Error("nudges need five numbers each: when, and x, y and the velocity after it");
      found.nudges = Array.from({ length: all.length / 5 }, (_, i) => ({ t: all[5 * i], state: /** @type {State} */ (all.slice(5 * i + 1, 5 * i + 5)) }));
      if (found.nudges.some(({ t }, i, list) => !(t > (list[i - 1]?.t ?? 0)))) throw new Error("the times of nudges do not rise");
    } else if (flipper) {
      found.presses[flipper.name] = numbers(text, name);
      if (found.presses[flipper.name].some((t, i, all) => i > 0 && !(t > all[i - 1]))) throw new Error(`the times of ${name} do not rise`);
    } else if (!["v", "table", "note"].includes(name)) throw new Error(`${name.slice(0, 40)} is no part of a link of this table`);
  }
  return found;
}

/** The same game in Python. @param {string} table @param {Played} game */
export function python(table, game) {
  const changed = Object.entries(game.changes), pressed = Object.entries(game.presses).filter(([, times]) => times.length);
  const lines = ["import grazing as gz", "", `T = gz.read_table("${table}")`];
  if (changed.length) lines.push(`T = T.replace(**{${changed.map(([name, value]) => `"${name}": ${value}`).join(", ")}})`);
  if (pressed.length) {
    lines.push("presses = gz.presses(", ...pressed.map(([name, times]) => `    ${name}=[${times.join(", ")}],`), ")", "T = gz.table(T.objects, T.rho, T.g, T.tilt, presses)");
  }
  const end = Math.max(game.end ? game.t + BEYOND : game.t, 1e-3), tuple = (/** @type {State} */ state) => `(${state.join(", ")})`;
  if (game.nudges.length) {
    // from nudge to nudge: when each part begins, and the ball then
    lines.push("legs = [", ...[{ t: 0, state: game.start }, ...game.nudges].map(({ t, state }) => `    (${t}, ${tuple(state)}),`), "]", `ends = [start for start, _ in legs[1:]] + [${end}]`);
    lines.push("flown = [gz.trajectory(T, state, start, until) for (start, state), until in zip(legs, ends)]");
    lines.push("print([name for part in flown for name in part.impact_wall.values], flown[-1].exit.item())", "gz.plot.table(T, flown[-1])", "");
  } else lines.push(`flown = gz.trajectory(T, ${tuple(game.start)}, until=${end})`, "print(flown.impact_wall.values, flown.exit.item())", "gz.plot.table(T, flown)", "");
  return lines.join("\n");
}
