// @ts-check
/** The guide beside the pictures: the steps of the tour with their questions, and the note that a link carries. */
import { nodes, typeset } from "./controls.js";
import { note } from "./note.js";
import { LONGEST_NOTE, numeral } from "./state.js";
import { TOUR } from "./tour.js";

/** @typedef {import("./state.js").State} State */
/** What the page lends. @typedef {{change: (part: object) => void, present: (shown: Partial<State>) => void, state: () => State}} Page */

const byId = (/** @type {string} */ id) => /** @type {any} */ (document.getElementById(id));
/** Numbers of a text that sliders change: a symbol, and what the state calls it. @type {Record<string, string>} */
const SYMBOLS = { d: "offset", r: "r", l: "l", λ: "lam", μ: "mu" };
const minus = (/** @type {string} */ text) => text.replace("-", "−");

/** A text in which each such number is followed by a place for what it is now, which is not read aloud at every move of a slider. @param {string} text */
const followed = (text) => text.split(/((?<![a-z])[dlrλμ] = −?\d[.\d]*(?<!\.))/).flatMap((part, i) => {
  if (i % 2 === 0) return nodes(part);
  const place = document.createElement("span"), [symbol, value] = part.split(" = ");
  Object.assign(place.dataset, { of: SYMBOLS[symbol], told: value.replace("−", "-") });
  place.ariaLive = "off";
  return [part, place];
});

/** Begin, turn and end the tour by its buttons, and write the note; returns what shows a state. @param {Page} page */
export function guided({ change, present, state }) {
  const visit = (/** @type {number} */ n) => TOUR[n - 1] && present({ pinned: "", ...TOUR[n - 1].state, tour: n });
  byId("tour").addEventListener("click", () => visit(1));
  byId("back").addEventListener("click", () => visit(state().tour - 1));
  byId("next").addEventListener("click", () => visit(state().tour + 1));
  byId("leave").addEventListener("click", () => change({ tour: 0, answer: 0 }));
  byId("write").maxLength = LONGEST_NOTE;
  byId("write").addEventListener("input", () => change({ note: byId("write").value }));
  const guide = byId("guide"), [back, next] = [byId("back"), byId("next")];
  /** @type {TOUR[number] | undefined} */
  let told;

  /** @param {TOUR[number] | undefined} step @param {State} now */
  function ask(step, { tour, answer }) {
    const asked = step?.question, box = byId("question");
    box.hidden = !asked;
    byId("told").hidden = !asked || !answer;
    if (!asked || !step) return;
    if (told !== step) {
      typeset(byId("ask"), asked.ask);
      byId("choices").replaceChildren(...asked.choices.map((text, i) => {
        const button = document.createElement("button");
        Object.assign(button, { type: "button", textContent: text });
        button.addEventListener("click", () => present({ ...step.state, ...asked.shown, tour, answer: i + 1 }));
        return button;
      }));
    }
    [...byId("choices").children].forEach((button, i) => {
      const right = Boolean(answer) && i === asked.right, wrong = i === answer - 1 && !right;
      button.className = right ? "right" : wrong ? "wrong" : "";
      button.setAttribute("aria-pressed", String(i === answer - 1));
      typeset(button, `${right ? "✓ " : wrong ? "✗ " : ""}${asked.choices[i]}`);
    });
    typeset(byId("told"), answer ? asked.told : "");
  }

  return (/** @type {State} */ now) => {
    const step = TOUR[now.tour - 1], focused = document.activeElement, left = !step && guide.contains(focused);
    guide.hidden = !step;
    if (left) byId("tour").focus();
    note(byId("note"), now.note);
    if (byId("write") !== focused) byId("write").value = now.note;
    ask(step, now);
    if (step && told !== step) {
      byId("guide-text").replaceChildren(...followed(step.text));
      guide.scrollTop = 0;
      // on a phone all controls lie where the guide would be
      if (!guide.offsetHeight && document.body.matches(".all")) byId("more").click();
    }
    told = step;
    if (!step) return;
    for (const place of byId("guide-text").querySelectorAll("[data-of]")) {
      const value = /** @type {Record<string, any>} */ (now)[place.dataset.of], text = value === Number(place.dataset.told) ? "" : ` (now ${minus(numeral(value))})`;
      if (place.textContent !== text) place.textContent = text;
    }
    typeset(byId("guide-title"), `${now.tour} of ${TOUR.length}: ${step.title}`);
    const way = /** @type {HTMLAnchorElement | null} */ (document.querySelector("nav a")); // where the table lies, if this page has one
    byId("guide-link").hidden = !step.link || !way;
    byId("guide-link").href = `${way?.getAttribute("href")}?tour`;
    typeset(byId("guide-link"), step.link ?? "");
    back.disabled = now.tour === 1;
    next.disabled = now.tour === TOUR.length;
    // a button that is switched off loses the focus: the other one takes it
    if (focused === next && next.disabled) back.focus();
    if (focused === back && back.disabled) next.focus();
  };
}
