"""Flippers beside a ball that slides: none is passed, and few steps are taken."""

from math import cos, pi, sin

import numpy as np

import grazing as gz
from grazing.billiard import swept as module
from grazing.billiard.elements import slid
from grazing.billiard.flippers import AT, OMEGA, PIECE_WIDTH, REACH
from grazing.billiard.turning import begin_of, clock_of, direction_at, piece_at
from grazing.kernel.primitives import behind
from grazing.maps.collisions import plain_block

#: The arc of the bowl, from inside.
BOWL, RHO = 14, 0.1


def bowl(up=9.0, down=4.0, pivot=(1.0, 1.0), length=2.0):
    law, corners = gz.newton(0.0), ((0.0, 12.0), (4.0, 12.0), (4.0, 0.0))
    one = gz.flipper("L", pivot, length, 0.2, -0.2, 0.5, gz.newton(0.5), up=up, down=down)
    walls = [gz.segment("left", (0.0, 0.0), corners[0], law), gz.segment("top", *corners[:2], law)]
    walls += [gz.segment("right", *corners[1:], law), gz.arc("bowl", (2.0, 2.2), 2.2, pi, 2.0 * pi, law)]
    table = gz.table([one, *walls], rho=RHO, tilt=0.4, player=gz.flips(2.3, 0.5, 0.2))
    return plain_block(table, list(table.params.values()))


def motion(block, clock):
    """Return what moves the flipper at a time: its row, the piece of its motion, when that begins and ends."""
    row = module.flippers_of(block)
    pieces, phase = behind(row, int(row[AT])), clock_of(clock, row)
    number, turns = piece_at(0.0, phase, row, pieces)
    begin, end = (begin_of(number + k, turns, phase, row, pieces) for k in range(2))
    return row, behind(pieces, PIECE_WIDTH * number), begin, end


def room(block, state, t, clock):
    """Return how far the ball is from the flipper after a time of its slide, and how near counts as a touch."""
    row, piece, begin, _end = motion(block, clock)
    x, y, vx, vy = slid(BOWL, *state, t, clock, block)
    width = module.TOUCH * (abs(x) + abs(y) + row[REACH])
    ux, uy, _turned = direction_at(t, begin, piece)
    return module.room_beside(row, ux, uy, piece[OMEGA], x, y, vx, vy, width)[0], width


def counted(monkeypatch):
    steps, before = [], module.room_beside
    monkeypatch.setattr(module, "room_beside", lambda *given: steps.append(1) or before(*given))
    return steps


def test_it_comes_loose_in_few_steps_from_a_flipper_that_has_squeezed_it_along_a_bowl(monkeypatch):
    """It took 100,000 of them, and each of 700 impacts without any time looked ahead to that: minutes."""
    state = 3.203704010057474, 0.4792162668796651, 12.414911339166954, 8.684344392520032
    steps, clock = counted(monkeypatch), 5.466361969815987
    assert module.swept(BOWL, *state, False, 0.00863803018401299, clock, bowl()) == (0.00863803018401299, -1)
    assert len(steps) < 1000


def test_no_flipper_is_passed():
    """Until the time that is found there is room, and there it is touched."""
    random, hits = np.random.default_rng(1), 0
    for _ in range(100):
        fast, short = random.uniform(1.0, 12.0, 2), random.uniform(0.0, 0.1)
        block = bowl(*fast, (1.0 + 0.5 * short, 1.0 + 0.2 * short), 2.0 - short)
        clock = random.choice([2.5, 2.52, 3.0, 3.05])  # on its way up and down
        angle = random.uniform(1.4 * pi, 1.9 * pi)
        speed = random.uniform(0.0, 9.0) * (1.0 if angle < 1.65 * pi else -1.0)  # towards the tip
        away = 2.2 - RHO
        state = 2.0 + away * cos(angle), 2.2 + away * sin(angle), -speed * sin(angle), speed * cos(angle)
        if not room(block, state, 0.0, clock)[0] > 1e-3:
            continue
        t, met = module.swept(BOWL, *state, False, motion(block, clock)[3], clock, block)
        for s in np.linspace(0.0, t, 100)[:-1]:
            h, width = room(block, state, s, clock)
            assert h >= -width
        hits += met >= 0
        assert met < 0 or abs(room(block, state, t, clock)[0]) <= 2.0 * width
    assert hits > 5
