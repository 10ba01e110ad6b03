// @ts-check
/** What is taken along: links and programs to copy, pictures to save. */
import { theme } from "./colours.js";
import { magnify, resolution } from "./plot.js";
import { toFragment } from "./state.js";
import { canvasOf, layout, svgOf } from "./svg.js";
import { command, python } from "./text.js";
import { reach } from "./where.js";

/** @typedef {import("./main.js").View} View */
/** @typedef {import("./state.js").State} State */
/** What the page lends: the view on screen, further sheets above it, its state, whether it has a picture, and what puts the state into the address. @typedef {{view: () => View | undefined, more: () => import("./svg.js").Panel[], repaint: () => void, state: () => State, drawn: () => boolean, address: () => void}} Page */

const said = () => /** @type {HTMLElement} */ (document.getElementById("said"));

/** @param {string} text */
function say(text) {
  said().textContent = text;
  setTimeout(() => said().textContent === text && (said().textContent = ""), 4000 + 60 * text.length);
}

/** @param {Page} page @param {string} kind link, python or command */
export async function copy(page, kind) {
  const view = page.view();
  view?.record?.(); // the ball's place goes into the link
  if (!view && kind !== "link") return say("this view needs a module that could not be loaded");
  if (kind !== "link" && !page.drawn()) return say("there is no picture to copy: see the message above");
  if (kind !== "link" && Number.isNaN(view?.raster().low)) return say("the picture is not there yet");
  page.address();
  const text = kind === "link" || !view ? location.href : (kind === "python" ? python : command)(page.state(), view.raster());
  try {
    await navigator.clipboard.writeText(text);
    say(`${kind} copied${kind === "link" ? reach() : ""}`);
  } catch {
    // no leave to use the clipboard: show the text, selected
    const field = document.createElement("textarea");
    field.value = text;
    field.setAttribute("aria-label", `${kind}, to be copied`);
    said().replaceChildren(field);
    field.select();
  }
}

/** The sheets that are seen. @param {Page} page @param {View} view */
const panels = (page, view) => [...page.more(), ...view.panels()].filter(({ sheet }) => sheet.canvas.offsetParent);

/** The picture on screen as an SVG file. @param {Page} page @param {View} view @param {State} state */
function vectors(page, view, state) {
  const about = `${view.summary().map(({ text, exact = "" }) => text + exact).join("\n")}\n${toFragment(state)}`;
  return svgOf(panels(page, view), { title: `grazing explorer: ${document.querySelector(`[data-view=${state.view}]`)?.textContent}`, about, paper: theme().paper });
}

/** Save the picture on screen, all of its sheets. @param {Page} page @param {string} kind png or svg */
export function save(page, kind) {
  const view = page.view(), state = page.state();
  if (!view || !page.drawn()) return say("there is no picture to save");
  const keep = (/** @type {Blob | null} */ blob) => {
    if (!blob) return say("this browser gives the page no canvas: save the SVG");
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = `grazing-${state.view}.${kind}`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };
  if (kind === "svg") return keep(new Blob([vectors(page, view, state)], { type: "image/svg+xml" }));
  const wide = Number(/** @type {HTMLSelectElement} */ (document.getElementById("times")).value);
  magnify(wide ? wide / (layout(panels(page, view)).width * resolution()) : 1);
  page.repaint();
  const canvas = canvasOf(panels(page, view), theme().paper, resolution());
  magnify(1);
  page.repaint();
  if (canvas) canvas.toBlob(keep);
  else keep(null);
}
