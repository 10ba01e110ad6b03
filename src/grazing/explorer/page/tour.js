// @ts-check
/**
 * A guided tour: what to see, a question to answer before the picture does, and the state that shows the answer.
 * `shown` is what changes in the picture once the question is answered.
 */

const STANDARD = { alpha: 3, k: 1, omega: 2.2, t0: 0, r: 0.8, law: "active", V: 0.4 };
const CHAOS = { ...STANDARD, view: "ball", omega: 6, V: 0, offset: -0.2, reach: /** @type {[number, number]} */ ([-0.3, 0]) };

/** @typedef {Partial<import("./state.js").State>} Shown */
/** @typedef {{ask: string, choices: string[], right: number, told: string, shown: Shown}} Question */

/** @type {{title: string, text: string, state: Shown, question?: Question, link?: string}[]} */
export const TOUR = [
  {
    title: "A ball above a bumper",
    text: "A driven, damped ball moves above a wall at u = 0. With d = 0.14 the drive holds it clear of the wall: it swings once in each period of the forcing and never hits.",
    state: { ...STANDARD, view: "ball", offset: 0.14 },
  },
  {
    title: "The graze",
    text: "Let d fall to the left end of its slider. A hair below that end, at d = k²a ≈ 0.13096, the lowest point of the swing just touches the wall: the graze. Now think of d below even that by a hair: the ball touches at almost no speed, and the bumper adds its kick V.",
    state: { ...STANDARD, view: "ball", offset: 0.14, reach: [0.131, 0.16] },
    question: {
      ask: "How far does the motion change?",
      choices: ["By a hair: the touch is slight", "At once by much"],
      right: 1,
      told: "However slight the touch, the kick is whole: from one value of d to the next the ball is thrown high, here once in six periods: wait for the 1 in the word. Each 0 is a period without an impact.",
      shown: { offset: 0.1305, reach: [0.05, 0.16] },
    },
  },
  {
    title: "The jump",
    text: "Each column of this diagram is one value of d, seen once in each period. Right of the graze lies one point. Left of it the attractor is large at once: a jump.",
    state: { ...STANDARD, view: "oscillator", offset: 0.1305, reach: [0.12, 0.135], reduced: false },
    question: {
      ask: "Take the kick away, V = 0: the wall only returns 80 % of the speed. Is there still a jump?",
      choices: ["Yes, the same", "No: it grows from nothing, at first steeply", "No: it grows from nothing, in a straight line"],
      right: 1,
      told: "Without the kick the attractor grows from the graze without a jump, yet with infinite slope: the square root of a low impact. The kick opens the gap.",
      shown: { V: 0 },
    },
  },
  {
    title: "Adding",
    text: "As d rises towards the graze, orbits with one impact in 2, 3 and 4 periods follow one another: their words are 01, 001, 0001. Colours name periods; the pale bands are the windows that theory predicts.",
    state: { ...STANDARD, view: "oscillator", offset: 0.112, reach: [0.05, 0.125], reduced: false },
    question: {
      ask: "Which word comes after 0001?",
      choices: ["0002", "00001", "00010001"],
      right: 1,
      told: "One more period of flight is added each time: 00001, 000001 and so on. In the window of each N the ball hits once in N periods; zoom in at the graze to see more of them.",
      shown: { offset: 0.127, reach: [0.12, 0.132] },
    },
  },
  {
    title: "Overlap",
    text: "At d = 0.1225 the window of period 4 has begun, and that of period 3 has not ended.",
    state: { ...STANDARD, view: "oscillator", offset: 0.1225, reach: [0.118, 0.128], reduced: false },
    question: {
      ask: "Balls start at many places, all with this same d. Where do they end?",
      choices: ["All on period 3", "All on period 4", "Some on 3 and some on 4", "On no orbit: chaos"],
      right: 2,
      told: "Both orbits are stable, and the start decides. In the chart each colour is the set of starts that end on one of them.",
      shown: { view: "chart", chart: "basins" },
    },
  },
  {
    title: "Hysteresis",
    text: "Move d up slowly, with one ball that lives through it all, and then down again.",
    state: { ...STANDARD, view: "ball", offset: 0.1005, reach: [0.09, 0.13] },
    question: {
      ask: "Does the ball jump at the same values of d on both ways?",
      choices: ["Yes", "No: later on each way", "No: sooner on each way"],
      right: 1,
      told: "The ball stays on its orbit until that ends or loses its stability, and the neighbour has begun long before: going up it jumps at the upper end of the overlap, going down at the lower one.",
      shown: { sweeps: true },
    },
  },
  {
    title: "Cobweb",
    text: "Near the graze a map of one number tells the same story: x → λx + μ without an impact, for x < 0; x → μ − l − √x with one. Take λ = 0.5, l = 0.1, μ = 0.15, and step.",
    state: { view: "gap", lam: 0.5, l: 0.1, span: [-0.05, 0.35], mu: 0.15, x0: 0.2, web: 4 },
    question: {
      ask: "Each step multiplies a distance by the slope where it is made. Left of 0 that is λ = 0.5. And just right of 0?",
      choices: ["Also small", "Exactly −1", "As large as you like"],
      right: 2,
      told: "The square root is infinitely steep at 0: the least difference between two balls that graze becomes a large one. A periodic orbit is stable only if its point on the right lies far enough from 0: where it comes too near, it doubles its period.",
      shown: { web: 60 },
    },
  },
  {
    title: "The gap",
    text: "At λ = 0.5 and l = 0 the windows of 3 and 4 are apart, and chaos fills the room between them. The gap l is in proportion to the kick V.",
    state: { view: "gap", lam: 0.5, l: 0, span: [-0.05, 0.35], mu: 0.1 },
    question: {
      ask: "Open the gap to l = 0.1. What do the windows do?",
      choices: ["They shrink, and chaos grows", "They grow, and overlap"],
      right: 1,
      told: "Above, the gap closed; below, open. From l = 0.0586 on the windows overlap: the dashed edge μ_PD passes the solid edge μ_BC of its neighbour. So near a graze a bumper's kick makes periodic orbits coexist where a passive wall leaves room for chaos.",
      shown: { l: 0.1, pinned: "view=gap&lam=0.5&l=0&span=-0.05:0.35&mu=0.1" },
    },
  },
  {
    title: "Chaos",
    text: "A passive wall, driven almost three times as fast. Think of a second ball that begins close to this one.",
    state: CHAOS,
    question: {
      ask: "How does their distance grow, until it is as large as the motion itself?",
      choices: ["By the same amount in each period", "By the same factor in each period, on average"],
      right: 1,
      told: "The logarithm of that factor is the Lyapunov exponent λ, here about 0.4 a period (measured below). A start that is known ten times as well can be foretold for six periods longer, and no more.",
      shown: { twin: true },
    },
  },
  {
    title: "Chatter",
    text: "No kick, and a steady push towards the wall: d = −0.5. Each hit keeps a part of the speed, r = 0.7, so one hop follows another, ever lower, without end: ∞ impacts.",
    state: { ...STANDARD, view: "ball", V: 0, r: 0.7, offset: -0.5, reach: [-0.6, 0.1] },
    question: {
      ask: "Does the ball ever lie still on the wall?",
      choices: ["No: after each hop comes another", "Only as far as one can see", "Yes, after a finite time"],
      right: 2,
      told: "Each flight is about r times as long as the one before: a geometric series, whose infinitely many terms have a finite sum. Then the ball rests until the force lifts it. C in the word stands for such a chatter.",
      shown: {},
    },
  },
  {
    title: "What the paper left open",
    text: "A real machine moves in a plane, among several bumpers, with a player. The pinball table of the explorer takes that up: at a graze of a bumper its future splits by the same square root with the same kind of gap. Here, the theory names the orbits with one impact, and their windows; between them other orbits and chaos share the room. Zoom into the diagram, and look.",
    state: { view: "gap", lam: 0.9, l: 0.4, span: [0.05, 0.3], mu: 0.12 },
    link: "To the pinball table",
  },
];
