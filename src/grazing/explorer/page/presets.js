// @ts-check
/** Figures of the paper, by number: what differs from the defaults. */

const STANDARD = { alpha: 3, k: 1, omega: 2.2, t0: 0, r: 0.8, law: "active" };
const SHALLOW = { ...STANDARD, view: "strobe", omega: 2.1, t0: 2.2, offset: 0.11, V: 0.2, u0: 0.03, v0: -0.23 };
const gap = (/** @type {number} */ lam, /** @type {number} */ l, /** @type {[number, number]} */ span, /** @type {number} */ mu, more = {}) => ({ view: "gap", lam, l, span, mu, ...more });

/** The exercises of docs/exercises.md: what is asked, the link where it begins, here or on the page of tables, and the answer. @type {Record<string, [string, string, string]>} */
export const EXERCISES = {
  "The graze": ["Let d fall until the ball just touches the bumper. Where is that, and which formula gives it? Multiply ω by 1.5: does the graze move up or down?", "#version=2&view=ball&offset=0.14",
    "At d = k²a ≈ 0.13096, where a = 1/√((k² − ω²)² + α²ω²) is the amplitude of the motion without impacts: its mean is d/k². A faster force moves the ball less, so the graze moves down, to 0.0715."],
  "Adding": ["Click in the windows from left to right. How do the words go on? By which factor does each window end nearer to the graze than the one before?", "#version=2&view=oscillator&reach=0.12:0.1312&offset=0.1292&reduced=no",
    "001, 0001, 00001 and so on: one more period of flight each. The factor is nearly λ = 0.336, by which a period without an impact brings the ball nearer to its swing."],
  "Coexistence and hysteresis": ["For which d near 0.1225 do two orbits live? Carry the ball there from 0.119 and from 0.127: on which is it? Which share of starts goes to each (Charts)?", "#version=2&view=ball&offset=0.1225&reach=0.118:0.128&sweeps=yes&chart=basins",
    "From 0.1219 to 0.1233, where the windows of 0001 and 001 overlap. From below the ball stays on 001, from above on 0001. Of starts with 0 ≤ u ≤ 0.5 and |v| ≤ 0.8 about 68 % go to 0001 at 0.1225, though the page finds it from nearly all of its own starts: a share is one of a region."],
  "Cobweb": ["Let μ rise until the orbit of period 3 ends, and fall until one of period 4 takes its place. What does the point on the right do at each end?", "#version=2&view=gap&lam=0.5&l=0.1&span=-0.05:0.35&mu=0.15&x0=0.2&web=3",
    "At μ = 0.1713 its highest point on the left reaches 0, the border: a collision. At μ = 0.0411 its point on the right has come so near to 0 that the slope of a turn is −1, as the multiplier says: it doubles. From the end of the doubled orbit, just below 0.0411, all starts go to period 4, LLLR, whose window began at 0.0444: that is the jump that is seen."],
  "Chaos": ["Start the twin, and read its λ and how sure it is. For how many more pushes is the ball foretold if its start is known a thousand times as well?", "#version=2&view=ball&omega=6&V=0&offset=-0.2&reach=-0.3:0",
    "λ is 0.38 a push, to about 0.02, the standard error of 1000 pushes that the page writes behind ±: ln 1000 / 0.38 ≈ 18 pushes. Each digit buys six."],
  "Chatter": ["The force hardly changes while the ball hops. If one hop lasts a time τ, how long is it until the ball lies still? Does it with r = 0.8, with 0.9?", "#version=2&view=ball&V=0&r=0.7&offset=-0.5&reach=-0.6:0.1",
    "Each hop lasts r times as long: τ(1 + r + r² + …) = τ/(1 − r), which is 3.3 τ for r = 0.7: there the word is C. With r = 0.8 it would be 5 τ and with r = 0.9 10 τ, but the force turns before: the ball is lifted off while it hops, there is no rest, and the word counts its hops."],
  "The table": ["Launch a ball and split it, and read in how many seconds near balls part tenfold. How much longer do you foresee the ball if you place it a thousand times as exactly? Where does the curve leap?", "#table=classic",
    "Three times as long as you read, about a second in many games: a thousand is three times tenfold. It leaps where some of the near balls hit a bumper that others miss: there the kick parts them at once."],
};

/** @type {Record<string, {title: string, state: Partial<import("./state.js").State>}>} */
export const PRESETS = {
  "1.2": { title: "Passive oscillator, period 2", state: { ...STANDARD, view: "ball", V: 0, offset: 0.12 } },
  "1.3": { title: "Passive oscillator, orbit diagram", state: { ...STANDARD, view: "oscillator", V: 0, offset: 0.12 } },
  "1.5": { title: "Active oscillator, period 3", state: { ...STANDARD, view: "ball", V: 0.4, offset: 0.12 } },
  "1.6": { title: "Active oscillator, orbit diagram", state: { ...STANDARD, view: "oscillator", V: 0.4, offset: 0.12 } },
  "2.1": { title: "Zero-time map of a low impact, the further picture", state: SHALLOW },
  "2.2": { title: "Stroboscopic against discontinuity map", state: SHALLOW },
  "3.1": { title: "Cobweb, λ = 0.8, l = 1, μ = 0.5", state: gap(0.8, 1, [-0.1, 1.2], 0.5) },
  "3.2": { title: "Gap map, λ = 0.34, l = 0.21", state: gap(0.34, 0.21, [-0.1, 0.6], 0.2) },
  "3.3a": { title: "Gap map, λ = 0.5, l = 0", state: gap(0.5, 0, [-0.05, 0.35], 0.15) },
  "3.3b": { title: "Gap map, λ = 0.5, l = 0.1", state: gap(0.5, 0.1, [-0.05, 0.35], 0.15) },
  "3.3c": { title: "Gap map, λ = 0.5, l = 0.5", state: gap(0.5, 0.5, [-0.05, 0.35], 0.15) },
  "3.4": { title: "Edges of 3 and 4 against the gap, λ = 0.5", state: { view: "edges", lam: 0.5, periods: [3, 4], gaps: [0, 0.5], span: [0, 0.4], l: 0.1, mu: 0.1 } },
  "3.5a": { title: "Gap map, λ = 0.9, l = 0: robust chaos", state: gap(0.9, 0, [-0.05, 0.6], 0.1) },
  "3.5b": { title: "Gap map, λ = 0.9, l = 0.4", state: gap(0.9, 0.4, [-0.05, 0.6], 0.2) },
  "3.5c": { title: "Gap map, λ = 0.9, l = 0.8", state: gap(0.9, 0.8, [-0.05, 0.6], 0.2) },
  "3.6": { title: "Edges of 3, 4 and 5 against the gap, λ = 0.9", state: { view: "edges", lam: 0.9, periods: [3, 5], gaps: [0, 1], span: [0, 1], l: 0.7, mu: 0.42 } },
  "3.7": { title: "Close-up near the graze, λ = 0.9, l = 0.8", state: gap(0.9, 0.8, [0.002, 0.06], 0.03, { transient: 3000 }) },
};
