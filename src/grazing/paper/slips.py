"""Where the paper is wrong or loose: the numbered list to which corrected claims refer."""

SLIPS = {
    1: "The graze of the standard set is at d = k²a = 0.1309618694, not at about 0.135.",
    2: "Before Figure 3.2 the closing condition is x1 = −√x_N + μ − l, the root over x_N alone; and in the proof of "
    "Proposition 3.1 x_(N−1) is the greatest negative iterate, not a positive one.",
    3: "For λ = 0.9, l = 0 the paper's own formula gives μ_PD,3 = 0.181577, not 0.17.",
    4: "Two thresholds are read off figures: period 5 is stable for l > 0.179624 (λ = 0.9), not 0.19; periods 3 and 4 "
    "coexist from l = 0.058594 (λ = 0.5), not 0.05.",
    5: "The text on Figure 3.4 names Ω2 ∩ Ω3 and the distance of μ_BC,4 from μ_BC,3; the figure is about Ω3 ∩ "
    "Ω4, whose width is μ_BC,4 − μ_PD,3.",
    6: "Figure 3.2: l = 0.21 does not belong to the physical parameters named; with the acceleration at the graze, "
    "A = ω²a = 0.633855, it is 0.324676 for V = 0.2 and 0.649353 for V = 0.4.",
    7: "(2.5) is P_T alone, no impact occurs there; the matrix B has −k² where −1 is printed; in the zero-time "
    "map R is the active law (1.3), not (1.2).",
    8: "A is the acceleration f − αv − k²u at the state, not the forcing f; it varies along the curve of Figure 2.2.",
    9: "The map in (x, y) is exact only up to terms in v²; and (2.6) also drops λx for x ≥ 0, which the "
    "two-dimensional map keeps.",
    10: "At l = 0 and 1/4 < λ < 2/3 some windows do intersect: 1 and 2 always, 2 and 3 for λ < 1/3, 3 and 4 for "
    "λ < 0.26376. The bound 1/4 is the limit of large N.",
    11: "Figure 3.5: for l > 0 it is the windows of large N, near μ = 0, that overlap; chaos between windows is "
    "left at moderate N.",
    12: "At μ = 0 the interval [−l, 0] is the trapping interval; the attractor is {0}. And a window says where "
    "an orbit is stable: the orbit exists, unstable, beyond it.",
    13: "The two maps of Figure 2.2 agree exactly above u(0) = 0.0395866, the graze of (2.4), not above 0.038.",
    14: "Below (2.3), with δ put in, (2.2) gives U3 = U0 − δ(V + (1 + r)√(V0² − 2AU0)). Harmless: the lowest "
    "order keeps U3 = U0.",
    15: "For V > 0 and α > 0, with an impact speed of the order of the time to the wall, as near a graze, the "
    "neglected terms are O(δ²) in (2.2) and O(δ) in (2.3), one order lower than printed: the "
    "impact changes the acceleration by −α(v⁺ − v⁻). More terms of (2.2) are then not a better map.",
    16: "For N = 1 the formula of μ_BC,N divides by zero: the window of the fixed point has no upper edge.",
    17: "Ω_N is printed closed; it is open, with multiplier −1 at one end and no orbit at the other.",
}
