// @ts-check
/** The note that a link carries above the pictures; below what an exercise asks its answer, folded away. */
import { nodes } from "./controls.js";
import { EXERCISES } from "./presets.js";

/** Write a note, or none. What stands there already is left: it would be read aloud again, and an answer folded. @param {HTMLElement} box @param {string} text */
export function note(box, text) {
  box.hidden = !text;
  if (box.dataset.written === text) return;
  box.dataset.written = text;
  box.replaceChildren(...nodes(text));
  const answer = Object.values(EXERCISES).find(([ask]) => ask === text)?.[2];
  if (!answer) return;
  const folded = document.createElement("details"), name = document.createElement("summary"), told = document.createElement("p");
  name.textContent = "Answer";
  told.append(...nodes(answer));
  folded.append(name, told);
  box.append(" ", folded);
}
