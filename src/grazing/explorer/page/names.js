// @ts-check
/** Parameters in a visitor's words; what they are exactly is said in kernels.json. */

/** @type {Record<string, string>} */
export const WORDS = {
  offset: "steady push", V: "kick of the bumper", r: "bounce", omega: "pace of the pushes", alpha: "damping", k: "spring",
  sigma: "height of the bumper", trigger: "least hit that kicks", t0: "delay of the pushes", phase: "moment of the section",
  cos1: "push", sin1: "push, shifted", cos2: "push, twice as fast", sin2: "twice as fast, shifted", cos3: "push, three times as fast", sin3: "three times as fast, shifted",
  sigma_B: "height of the upper wall", r_B: "bounce above", V_B: "kick from above", trigger_B: "least hit above that kicks", cos_A: "walls move", sin_A: "walls move, shifted",
  lam: "slope", l: "gap", mu: "distance from the graze", u0: "start: height", v0: "start: velocity",
};

/** A text and the subscripts in it, in turn: those of one letter, as μ_PD and σ_B. @param {string} text */
export const pieces = (text) => text.split(/(?<!\w\w)_([A-Z]{1,2}|\d|sB?)\b/);
