// @ts-check
/** The way down from the machine to the paper: each table, and what has been taken away. */

/**
 * @typedef {{table: string, name: string, headline: string, text: string, sliders: string[], touch?: string, home?: number[], heights?: [number, number]}} Rung
 * sliders: names of parameters, those of several objects by the last part, as `*.V`; touch: the text where there are no keys; home: the launches that are shown first, from and to
 * which angle, and speed; heights: where a speed changes nothing, and balls are launched from these
 */

/** @type {Rung[]} */
export const RUNGS = [
  {
    table: "classic", name: "Pinball machine", sliders: ["*.V", "tilt"],
    headline: "Three bumpers kick the ball. Near a graze, a hair's breadth decides.",
    text: "Hold Space to pull the plunger, let go to launch; ← and → are the flippers; ↑, A and D nudge. Thumbs: the halves of the table.",
    touch: "Hold Launch to pull the plunger, let go to launch; the halves of the table are the flippers.",
    home: [0, 3.14, 2, 5],
  },
  {
    table: "galton", name: "Galton board", sliders: ["*.r", "tilt"],
    headline: "No bumper kicks, yet where the ball ends is decided by a hair.",
    text: "Launch drops a ball on the pins. Split it: the balls fall as a bell. Zoomed in a million times, the sand in the picture of launches has bands.",
  },
  {
    table: "three_discs", name: "Three discs", sliders: ["*.r"],
    headline: "Nothing but three discs: almost every ball leaves for good.",
    text: "No gravity, no kick. The fine lines in the picture of launches are balls that stay long.",
    home: [1.28, 1.5, 2.6, 4.1], heights: [-2, 4.19],
  },
  {
    table: "one_bumper", name: "One bumper", sliders: ["*.V", "*.r"],
    headline: "One bumper, and gravity that brings the ball back.",
    text: "Nearly the paper's machine: there the ball moves up and down only, and a force takes the place of gravity.",
  },
];
