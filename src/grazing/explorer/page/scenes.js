// @ts-check
/** The scenes: a view, and in charts what is charted. What each shows, zooms and says to do. */

const ZOOM = "drag to move the picture, zoom with the wheel or two fingers, at an axis that axis alone, or a box with Shift; a double click shows all. Keys: arrows, +, −, 0.";
const FOLLOWS = "The height follows the orbits until it is zoomed at its axis or by a box.";
const CHOOSE = `Click to choose the parameter, ${ZOOM} ${FOLLOWS}`;
const CHART = `Colours name the period that most random starts settle on. Click to choose both parameters, ${ZOOM}`;
/** What to do; `-two` for two walls, `-moving` for one that moves. @type {Record<string, string>} */
export const HINTS = {
  gap: `Click in the diagram to choose μ, ${ZOOM} ${FOLLOWS} In the cobweb drag the start, and step from it. Dashed: period doubling μ_PD; solid: border collision μ_BC; dotted: the graze.`,
  edges: `Click to choose l and μ, ${ZOOM} Dashed: period doubling μ_PD; solid: border collision μ_BC; between them the orbit is stable.`,
  oscillator: `${CHOOSE} Shaded windows are those that the normal form predicts; dotted: the graze.`,
  "oscillator-two": `${CHOOSE} The letters of a word are the walls that are hit, A below and B above.`,
  "oscillator-moving": CHOOSE,
  ball: "Take the ball and pull: it flies the other way. In the portrait put it where it shall begin. Drag the line in the diagram, or the slider whose track has its colours. The wheel or two fingers zoom each picture. Keys: Space pauses, S steps, arrows aim, Enter throws, 0 shows all. The faint curve is what most random starts settle on; the dots in the diagram are where this ball was at the section.",
  map: `${CHOOSE} Beside it drag the start, and step from it.`,
  "chart-gap": CHART,
  "chart-oscillator": CHART,
  "chart-map": CHART,
  "chart-basins": `Each point is an initial state at the strobe, its colour the attractor that it reaches; dots are points of the attractors. Click to choose a state, ${ZOOM}`,
  "chart-map-basins": `Each point is an initial state, its colour the attractor that it reaches; dots are points of the attractors. Click to choose the start, ${ZOOM}`,
  strobe: `Where both curves lie on one another the local map is exact; where they part, it is not. At a graze, dashed, both jump; dotted: an impact comes just at the end of the period. Click to choose the start of the zero-time map, ${ZOOM}`,
};
const CHARTS = "chart-gap chart-oscillator chart-basins chart-map chart-map-basins";
/** The scenes in which a control is shown; one not named here is shown with its section. @type {Record<string, string>} */
export const SHOWN = {
  span: "gap edges chart-gap", range: "gap", gaps: "edges chart-gap", periods: "edges",
  vary: "oscillator map chart-oscillator chart-map", reach: "oscillator map chart-oscillator chart-map", second: "chart-oscillator chart-map", heights: "chart-oscillator chart-map",
  coordinate: "oscillator map strobe", window: "oscillator map", reduced: "oscillator",
  positions: "chart-basins chart-map-basins", velocities: "chart-basins chart-map-basins", u0: "strobe", v0: "strobe", line: "strobe", order: "strobe",
  chart: CHARTS, chart_columns: CHARTS, chart_rows: CHARTS,
  theory: "gap oscillator", colour: "gap map oscillator", columns: "gap map oscillator", bins: "gap map oscillator",
  starts: "gap map oscillator", transient: "gap map oscillator", keep: "gap map oscillator", flow_starts: "oscillator", flow_transient: "oscillator", flow_keep: "oscillator",
  seed: "gap map edges oscillator chart-gap chart-oscillator chart-map", accuracy: `gap map edges oscillator ${CHARTS}`,
};
/** Axes that a picture zooms, by scene. @type {Record<string, string[]>} */
export const ZOOMED = {
  gap: ["span", "range"], map: ["reach", "window"], "chart-map": ["reach", "heights"], "chart-map-basins": ["positions", "velocities"], edges: ["gaps", "span"], oscillator: ["reach", "window"], ball: ["reach"], "chart-gap": ["span", "gaps"],
  "chart-oscillator": ["reach", "heights"], "chart-basins": ["positions", "velocities"], strobe: ["line"],
};
/** The module that each view cannot do without. @type {Record<string, string>} */
export const NEEDS = { gap: "gap", map: "map", edges: "gap", oscillator: "oscillator", ball: "oscillator", chart: "gap", strobe: "oscillator" };
