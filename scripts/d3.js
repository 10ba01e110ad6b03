// What the explorer's page takes from d3; `sh scripts/page.sh d3` bundles it into src/grazing/explorer/page/d3.mjs.
export { scaleLinear } from "d3-scale";
export { select } from "d3-selection";
export { zoom, zoomIdentity } from "d3-zoom";
