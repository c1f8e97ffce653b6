"""The error scale: colours must decode to the errors they stand for, on one scale for all maps."""

import numpy as np

from raytruth.reports.figures import scale
from raytruth.reports.figures.scale import DECADES, EXACT, LEVELS, MISMATCH, NON_FINITE, TABLE, UNDECIDED, paint


def clear(shape) -> np.ndarray:
    return np.zeros(shape, bool)


def decoded(pixels: np.ndarray) -> np.ndarray:
    """The errors that a reader takes from the colours, by nothing but the published table."""
    distance = np.abs(pixels[..., None, :].astype(int) - TABLE).sum(-1)
    assert (distance.min(-1) == 0).all()
    return scale.error_of(distance.argmin(-1))


def test_colours_decode_to_the_error_within_half_a_step():
    # a step is a factor of 10^(9/255) = 1.0846; rounding to the nearest level errs by at most its square root
    error = np.geomspace(1e-9, 1, 5000).reshape(50, 100)
    ratio = decoded(paint(error, clear(error.shape), clear(error.shape))) / error
    half_a_step = 10 ** (9 / 255 / 2)
    assert ratio.max() <= half_a_step * (1 + 1e-9) and ratio.min() >= (1 - 1e-9) / half_a_step


def test_the_scale_does_not_depend_on_the_picture():
    small, mixed = np.full((1, 1), 1e-6), np.array([[1e-6, 1.0]])
    assert (paint(small, clear((1, 1)), clear((1, 1)))[0, 0] == paint(mixed, clear((1, 2)), clear((1, 2)))[0, 0]).all()


def test_errors_beyond_the_ends_take_the_ends_colours():
    error = np.array([[1e-300, 1e-9, 1.0, 1e300]])
    pixels = paint(error, clear(error.shape), clear(error.shape))[0]
    assert (pixels[:2] == TABLE[0]).all() and (pixels[2:] == TABLE[-1]).all()


def test_marks_lie_outside_the_scale_and_keep_their_rank():
    error = np.array([[0.0, 0.5, 0.5, np.nan, 0.5, np.nan]])
    mismatch = np.array([[False, True, True, True, False, False]])
    undecided = np.array([[False, False, True, True, False, True]])
    expected = [EXACT, MISMATCH, UNDECIDED, NON_FINITE, TABLE[scale.level(0.5)], NON_FINITE]
    assert (paint(error, mismatch, undecided)[0] == np.array(expected)).all()
    colours = {tuple(c) for c in TABLE} | {tuple(c) for c in (EXACT, MISMATCH, UNDECIDED, NON_FINITE)}
    assert len(colours) == LEVELS + 4


def test_lightness_rises_all_the_way_so_that_order_survives_without_hue():
    luminance = (TABLE / 255.0) ** 2.2 @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(luminance) > 0).all()


def test_ticks_stand_where_their_decade_is():
    for tick in scale.TICKS:
        assert abs(tick.at / 100 * (LEVELS - 1) - scale.level(10.0**tick.exponent)) <= 0.5
    assert len(scale.TICKS) == DECADES + 1
