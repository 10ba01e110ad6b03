// @ts-check
/** What starts settle on, in a visitor's words. */

import { periodColour } from "./colours.js";
import { RESTS } from "./orbits.js";

/** @typedef {import("./jobs.js").Class} Class */

const NUMBERS = ["no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten"];
/** @param {number} n */
const spelt = (n) => NUMBERS[n] ?? String(n);
const TIMES = ["never", "once", "twice"];

/** One orbit. @param {Class} each */
function rhythm({ period, impacts, length, word }) {
  if (period < 1) return "it hits on and on and no tune repeats";
  if (RESTS.test(word)) return "it lies on the bumper";
  if (impacts == null) return "its hits come ever faster, without end, until it lies still; then the force lifts it off";
  if (impacts === 0) return "it swings and never hits";
  const hits = TIMES[impacts] ?? `${spelt(impacts)} times`;
  return `it hits ${hits} ${length === 1 ? "in every push" : `in ${spelt(length)} pushes`}: ${word}`;
}

/** The pieces of a sentence, each word with the colour of its period. @param {Class[]} classes @param {boolean} coming whether the ball is still on its way there @returns {import("./state.js").Line[]} */
export function tune(classes, coming = false) {
  const known = classes.filter(({ period }) => period !== 0);
  if (!known.length) return [{ text: "What becomes of it is not decided." }];
  const said = known.slice(0, 3).map((each) => ({ colour: periodColour(each.period), text: rhythm(each) }));
  const way = coming && known.every(({ period }) => period > 0) ? `It may be on its way to ${said.length > 1 ? "one of these" : "this"}: ` : "";
  if (said.length === 1) return [...(way ? [{ text: way }] : []), { ...said[0], text: `${way ? said[0].text : said[0].text[0].toUpperCase() + said[0].text.slice(1)}.` }];
  return [{ text: way || "The start decides: " }, ...said.flatMap((each, i) => [...(i ? [{ text: "; or " }] : []), each]), { text: "." }];
}
