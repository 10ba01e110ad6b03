// @ts-check
/** Colours of periods, as in the figures of the package, and a lighter set of the dark ones for dark pages. */

export const PERIODS = ["#1a1a1a", "#e69f00", "#0064a4", "#5cbceb", "#9c2a1b", "#e08fbf", "#00624a", "#b3b53c", "#5b2c83", "#f0d48a", "#1f7a8c", "#f2a07b", "#7a4a12", "#86d3b4", "#b0186b", "#b9b3e3"];
/** @type {Record<string, string>} */
const ON_DARK = { "#1a1a1a": "#f2f2f2", "#0064a4": "#3f8fdc", "#9c2a1b": "#dd5a48", "#00624a": "#1fa07c", "#5b2c83": "#a16ed2", "#1f7a8c": "#2fa5bd", "#7a4a12": "#b9803d", "#b0186b": "#e4509f" };

export const dark = matchMedia("(prefers-color-scheme: dark)");

/** The colour that period N always has. @param {number} N */
export function periodColour(N) {
  if (!(N >= 1)) return theme().chaos;
  const colour = PERIODS[(N - 1) % PERIODS.length];
  return dark.matches ? (ON_DARK[colour] ?? colour) : colour;
}

/** Red, green and blue, 0 to 255. @param {string} colour */
export function rgb(colour) {
  return [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16));
}

/** A share of a colour on paper, opaque: lines may cross without a darker place. @param {string} colour @param {number} share from 0 to 1 */
export function faded(colour, share) {
  const paper = rgb(theme().paper);
  return `#${rgb(colour).map((each, i) => Math.round(share * each + (1 - share) * paper[i]).toString(16).padStart(2, "0")).join("")}`;
}

/** Colours of paper and ink. */
export function theme() {
  return dark.matches
    ? { paper: "#14171a", ink: "#e8e8e8", faint: "#9aa3ab", line: "#3b4248", chaos: "#b4b4b4", graze: "#ff6b7d", wall: "#343a40", accent: "#6db3f2" }
    : { paper: "#ffffff", ink: "#1a1a1a", faint: "#5a6168", line: "#d5d9dd", chaos: "#6a6a6a", graze: "#b00020", wall: "#d9d9d9", accent: "#0064a4" };
}
