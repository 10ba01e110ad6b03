// @ts-check
/** The scenes: a view, and in charts what is charted. What each shows, zooms and says to do. */

const ZOOM = "drag to move the picture, zoom with the wheel or two fingers or a box with Shift; a double click shows all. Keys: arrows, +, −, 0.";
const CHOOSE = `Click to choose the parameter, ${ZOOM}`;
/** What to do; `-two` for two walls, `-moving` for one that moves. @type {Record<string, string>} */
export const HINTS = {
  gap: `Click in the diagram to choose μ, ${ZOOM} In the cobweb drag the start, and step from it. Dashed: period doubling μ_PD; solid: border collision μ_BC; dotted: the graze.`,
  edges: `Click to choose l and μ, ${ZOOM} Dashed: period doubling μ_PD; solid: border collision μ_BC; between them the orbit is stable.`,
  oscillator: `${CHOOSE} Shaded windows are those that the normal form predicts; dotted: the graze.`,
  "oscillator-two": `${CHOOSE} The letters of a word are the walls that are hit, A below and B above.`,
  "oscillator-moving": CHOOSE,
  ball: "Take the ball and pull: it flies the other way. In the portrait put it where it shall begin. Drag the line in the diagram, or the slider whose track has its colours. Keys: Space pauses, S steps, arrows aim and Enter throws. The faint curve is what most random starts settle on; the dots in the diagram are where this ball was at the section.",
  "chart-gap": `Colours name the period that most random starts settle on. Click to choose both parameters, ${ZOOM}`,
  "chart-oscillator": `Colours name the period that most random starts settle on. Click to choose both parameters, ${ZOOM}`,
  "chart-basins": `Each point is an initial state at the strobe, its colour the attractor that it reaches; dots are points of the attractors. Click to choose a state, ${ZOOM}`,
  strobe: `Where both curves lie on one another the local map is exact; where they part, it is not. At a graze both jump. Click to choose the start of the zero-time map, ${ZOOM}`,
};
/** The scenes in which a control is shown; one not named here is shown with its section. @type {Record<string, string>} */
export const SHOWN = {
  span: "gap edges chart-gap", range: "gap", gaps: "edges chart-gap", periods: "edges",
  vary: "oscillator chart-oscillator", reach: "oscillator chart-oscillator", second: "chart-oscillator", heights: "chart-oscillator",
  coordinate: "oscillator strobe", window: "oscillator", reduced: "oscillator",
  positions: "chart-basins", velocities: "chart-basins", u0: "strobe", v0: "strobe", line: "strobe", order: "strobe",
  chart: "chart-gap chart-oscillator chart-basins", chart_columns: "chart-gap chart-oscillator chart-basins", chart_rows: "chart-gap chart-oscillator chart-basins",
  theory: "gap oscillator", colour: "gap oscillator", columns: "gap oscillator", bins: "gap oscillator",
  starts: "gap oscillator", transient: "gap oscillator", keep: "gap oscillator", flow_starts: "oscillator", flow_transient: "oscillator", flow_keep: "oscillator",
  seed: "gap edges oscillator chart-gap chart-oscillator", accuracy: "gap edges oscillator chart-gap chart-oscillator chart-basins",
};
/** Axes that a picture zooms, by scene. @type {Record<string, string[]>} */
export const ZOOMED = {
  gap: ["span", "range"], edges: ["gaps", "span"], oscillator: ["reach", "window"], ball: ["reach"], "chart-gap": ["span", "gaps"],
  "chart-oscillator": ["reach", "heights"], "chart-basins": ["positions", "velocities"], strobe: ["line"],
};
/** The module that each view cannot do without. @type {Record<string, string>} */
export const NEEDS = { gap: "gap", edges: "gap", oscillator: "oscillator", ball: "oscillator", chart: "gap", strobe: "oscillator" };
