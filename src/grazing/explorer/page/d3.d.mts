/** What the page takes from d3, bundled by `sh scripts/page.sh d3`. */
export { scaleLinear, type ScaleLinear } from "d3-scale";
export { select } from "d3-selection";
export { zoom, zoomIdentity, type ZoomBehavior } from "d3-zoom";
