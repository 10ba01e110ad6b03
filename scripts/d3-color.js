// In the place of d3-color, when the page's d3 is bundled: it moves between numbers only, and colours are a sixth of the whole.
class None {}
export { None as color, None as cubehelix, None as gray, None as hcl, None as hsl, None as lab, None as lch, None as rgb };
