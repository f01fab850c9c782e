"""How finely a diagnosis computes: blocks, folds, grids, passes and lengths of lists; none is a limit of evidence."""

from __future__ import annotations

from dataclasses import dataclass

from validation.policy import number, shared

TUNED = "set on tuning seeds 0 and 1 of the bench, no sweep kept"


@dataclass(frozen=True)
class Effort:
    """Sizes of blocks, folds, grids and lists; finer ones cost time and should answer the same.

    Lengths and periods are the range that is searched.
    """

    # fmt: off
    # blocks, splits and folds
    least_samples: int = number(200, "shortest recording that is diagnosed: training and held-out segments need length")
    start_s: float = number(1.0, "time after a start or a pause in which a late measurement shows the field before",
        run="a hand-held log of 150 s, 50 ms late from the start: its first two samples made it an eddy current")
    start_share: float = number(0.02, "largest share of samples left out for a start")
    pause: float = number(5.0, "intervals, in medians, beyond which nothing is carried on from one sample to the next")
    block_s: float = number(5.0, "length of the blocks of sums")
    least_blocks: int = number(100, "blocks that a recording is cut into at least; shorter ones if need be")
    segment_blocks: int = number(4, "blocks of a segment, which is trained on or held out as a whole: 20 s")
    splits: int = number(5, "splits; each holds out other segments, for an event in a held-out gap is not seen by it")
    held_segments: int = number(2, "of so many segments as there are splits, those that one split holds out")
    least_segment_s: float = number(1.0, "least length of such a segment")
    colour_blocks: tuple[int, ...] = number((1, 4, 16), "blocks of the means whose excess is V: 5, 20 and 80 s")
    least_colour_means: int = number(8, "number of means of a length below which the length is not used for the colour")
    filled_block: float = number(0.5, "share of its samples that a block needs to count as a mean")
    folds: int = number(5, "folds of segments, each held out once")
    fold_s: float = number(20.0, "length of a segment of a fold at least")
    fold_share: float = number(1 / 60, "least length of a segment of a fold, as a share of the recording")

    # searches for wrong values, tones, jumps, windows and places
    burst_median: int = number(21, "number of samples about a burst whose median is the reference")
    spike_margin: int = number(2, "samples beside a held or clipped one whose jumps are no spikes")
    most_lobes: int = number(12, "lobes of the heading beyond which a tone is no lobe: a ripple would be one by chance",
        run="tuning seeds 0 and 1, a quadrotor's even turns: three and four lobes gain 45 times what their tones do")
    slowest_tone_hz: float = number(0.1, "slowest ripple: at a steady current a slower one fits any periodic motion",
        run=TUNED)
    least_tone_cycles: float = number(4.0, "cycles that a ripple goes through in the recording at least")
    fastest_pulse_s: float = number(30.0, "shortest period of a change of the field itself: vehicles turn faster")
    least_pulse_cycles: float = number(2.0, "cycles that such a change goes through in the recording at least")
    step_margin: float = number(0.02, "share of the recording at its ends in which a jump resembles iron")
    window_cells: int = number(80, "cells of the recording at whose borders an effect's begin and end are searched "
        "first")
    window_finer: int = number(8, "refinement of each further search")
    least_window: float = number(0.04, "least length of a window in the first search, as a share of the recording")
    place_margin_m: float = number(15.0, "distance beyond the path's box up to which a dipole's position is searched")
    other_place: float = number(0.25, "share of the path's extent by which a second grid exceeds its box, if sizes "
        "differ", run="a survey of 600 m over bodies at 86 m, and a sensor led past a magnet on a table within 2.5 m")
    other_scale: float = number(3.0, "ratio between this and the first grid's margin from which on sizes differ")
    about_stretch: float = number(6.0, "margin about the part with a large gap, in its extents: a body is three away")
    nearest_share: float = number(0.05, "the same as nearest_place_m, as a share of the extent of a short path")
    farthest_share: float = number(0.5, "the same as farthest_place_m, as a share of the extent of a long path")
    place_cells: int = number(7, "cells of the grid of places along an axis at least; twice as many at most")
    place_cell_m: float = number(10.0, "size of such a cell, between these limits")
    place_starts: int = number(4, "best places of the grid that are refined")

    # effects and their forms
    most_effects: int = number(3, "largest number of effects, and of changes of iron")
    listed_settings: int = number(50, "settings beyond which these are a search over the recording, which has a price")
    survival_mean_s: float = number(1.0, "length of the means for survival: rates are noisy")
    joint_passes: int = number(3, "largest number of refits of the iron with the accepted effects")
    joint_settled: float = number(0.1, "rms in sigma of the change of the target below which the target has settled")
    sweep_cycles: tuple[float, ...] = number(tuple(k / 16 for k in range(1, 13)), "cycles by which a tone leads or "
        "lags a tone of constant frequency at the end of a run")
    form_settings: int = number(40, "largest number of settings tried between the listed ones of a form")
    first_form_factor: float = number(10.0, "size of a first form over the effect's own: at equal size both coincide")

    # coloured noise models
    most_rows: int = number(12_000, "number of binned rows beyond which longer means are taken")
    memories: int = number(7, "number of Ornstein-Uhlenbeck processes of a noise model, evenly spaced in log memory")
    shortest_memory: float = number(3.0, "least memory of a slow process, in rows")
    longest_memory: float = number(4.0, "greatest memory, in lengths of the recording: a random walk")
    surrogates: int = number(16, "number of surrogates: columns of an effect shifted to and fro in time")
    tried_coloured: int = number(4, "number of candidates with a noise model of their own, the best in the screening")

    # slow noise
    bands: int = number(40, "bands of the spectrum, evenly spaced in log frequency")
    first_line: int = number(2, "first line of the spectrum that counts: below it the mean leaks in", run=TUNED)
    slow_mean_s: float = number(5.0, "length of means in which slow errors exceed the noise of a sample")
    step_s: float = number(5.0, "length of the means of innovations that are tested for jumps and courses")
    least_steps: int = number(40, "least number of such means, shorter if need be")
    most_steps: int = number(400, "largest number of such means, longer if need be: of more one is far by chance")
    swing_lags: int = number(8, "lags at which the innovations' correlation is tested")
    listed_noises: int = number(3, "number of effects listed as alternatives of a slow disturbance")

    # several recordings
    scatter_parts: int = number(4, "number of parts of a recording for the scatter of coefficients",
        alarms="of 49 white and 147 coloured lots of three with equal coefficients 4 differed at 5 %, none at 1 %",
        run="quadrotor, 280 s, flicker noise, attitude that wanders by 0.01 and 0.1 degrees over 60 s, effects of 0.03 "
        "to 0.3 of the noise: at 1 % with 6 parts 5 of these 147 differed, by surrogates alone 10 of the first 36")

    # the course of the gap, and channels that it follows
    part_cells: int = number(120, "cells of the recording between which the gap's size may change")
    least_part: float = number(0.04, "least length of such a part, as a share of the recording")
    phase_share: float = number(0.1, "share of a part of the run from which on a phase is listed")
    mean_lengths_s: tuple[float, ...] = shared("mean_lengths_s")
    least_mean_samples: int = number(5, "samples of a tested mean at least")
    least_tested_means: int = number(20, "least number of means of a tested length")
    filter_memory: int = number(10, "samples over which a low-pass or a delay in the model colours the noise itself")
    channel_bins: int = number(24, "bins of a channel")
    channel_segments: int = number(40, "segments dealt to two folds in turn")
    channel_mean_s: float = number(0.5, "length of the binned means")
    least_channel_means: int = number(400, "least number of such means, shorter if need be")
    most_channels: int = number(8, "number of listed channels")
    driver_tail: float = number(0.005, "share of a channel's samples at each end beyond which its curve is straight")
    most_curves: int = number(4, "largest number of channels with added curves",
        alarms="of 108 rests (white, coloured, a channel's shifted in time) on an AUV and a quadrotor beside three "
        "unrelated channels 2 had a curve: both of a periodic sawtooth, whose shift is a curve of it")
    followed_order: int = number(2, "powers of a channel followed by iron, beside named effects that explain less")
    followed_lags: int = number(3, "step in the list of lags tried for iron, or an effect with a window")

    # what to fly next
    least_leg_nats: float = number(0.1, "nats of the best leg below which no motion separates two effects")
    leg_margin: float = number(3.0, "nats of a planned leg over the nats that separate two effects")
    # fmt: on
