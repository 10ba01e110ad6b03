// @ts-check
/** The note that a link carries above the pictures; below what an exercise asks its answer, folded away. */
import { nodes } from "./controls.js";
import { EXERCISES } from "./presets.js";

/** Write a note, or none. What stands there already is left: it would be read aloud again, and an answer folded. @param {HTMLElement} box @param {string} note */
export function write(box, note) {
  box.hidden = !note;
  if (box.dataset.written === note) return;
  box.dataset.written = note;
  box.replaceChildren(...nodes(note));
  const answer = Object.values(EXERCISES).find(([ask]) => ask === note)?.[2];
  if (!answer) return;
  const folded = document.createElement("details"), name = document.createElement("summary"), told = document.createElement("p");
  name.textContent = "Answer";
  told.append(...nodes(answer));
  folded.append(name, told);
  box.append(" ", folded);
}
