// @ts-check
/** A guided tour through the paper's argument: what to see, and the state that shows it. */

const STANDARD = { alpha: 3, k: 1, omega: 2.2, t0: 0, r: 0.8, law: "active", V: 0.4 };

/** @type {{title: string, text: string, state: Partial<import("./state.js").State>}[]} */
export const TOUR = [
  {
    title: "A ball above a bumper",
    text: "A driven, damped ball moves above a wall at u = 0. With d = 0.14 the drive holds it clear of the wall: it swings once in each period of the forcing and never hits.",
    state: { ...STANDARD, view: "ball", offset: 0.14 },
  },
  {
    title: "The graze",
    text: "Let d fall. At d = k²a = 0.1309618693 the lowest point of the swing just touches the wall: the graze. A little lower the ball hits, slowly, and a bumper throws it off with the extra velocity V. Press “Step to next impact”.",
    state: { ...STANDARD, view: "ball", offset: 0.1305 },
  },
  {
    title: "The jump",
    text: "Each column of this diagram is one value of d, seen once in each period. Right of the graze lies one point. Left of it the attractor is large at once: the bumper's V makes it jump. Set V to 0 and see it grow from nothing instead.",
    state: { ...STANDARD, view: "oscillator", offset: 0.1305, reach: [0.12, 0.135], reduced: false },
  },
  {
    title: "Windows",
    text: "As d falls further, orbits of period 7, 6, 5, 4, 3, 2 follow one another, each with a single impact in its period: 001 means two periods of flight and one with an impact. Colours name periods. Zoom in at the graze to see more of them.",
    state: { ...STANDARD, view: "oscillator", offset: 0.112, reduced: false },
  },
  {
    title: "Coexistence",
    text: "Windows overlap. At d = 0.1225 an orbit of period 3 and one of period 4 are both stable, and the start decides which is reached. The words below say how many of the random starts reach each.",
    state: { ...STANDARD, view: "oscillator", offset: 0.1225, reach: [0.118, 0.128], reduced: false },
  },
  {
    title: "Reduction",
    text: "Near the graze a map of one number tells the same story: x → λx + μ without an impact, x → μ − l − √x with one. Below the full diagram is that of the map with the λ and l of this oscillator. It is right near the graze, and less and less so away from it.",
    state: { ...STANDARD, view: "oscillator", offset: 0.122, reduced: true },
  },
  {
    title: "The gap",
    text: "The gap l is in proportion to V. At λ = 0.5, l = 0 the windows of 3 and 4 are apart and chaos fills the room between them; from l = 0.0586 on they overlap. Move l and watch the dashed edge μ_PD pass the solid edge μ_BC of its neighbour.",
    state: { view: "gap", lam: 0.5, l: 0, span: [-0.05, 0.35], mu: 0.1 },
  },
  {
    title: "Robust chaos",
    text: "At λ = 0.9 without a gap there is no window left below that of period 3: chaos on a whole interval of μ. Open the gap and windows break into it.",
    state: { view: "gap", lam: 0.9, l: 0, span: [-0.05, 0.6], mu: 0.1 },
  },
  {
    title: "What is still open",
    text: "The theory names the maximal orbits, those with one impact, and their windows. For 0 < l, between the windows, other orbits and chaos share the room that is left, and the map does not say what the oscillator does far from its graze. A real pin-ball moves in a plane, among several bumpers, with a player: that is left to those who come next. Zoom into the diagram, and look.",
    state: { view: "gap", lam: 0.9, l: 0.4, span: [0.05, 0.3], mu: 0.12 },
  },
];
