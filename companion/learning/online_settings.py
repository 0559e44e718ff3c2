"""Settings of the online correction: the paper's, and ours."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, PositiveFloat

from companion.learning.correction import ConstantGain, Gain
from companion.learning.error_prediction import FormName
from companion.learning.features import Preview
from companion.learning.gaussian_process import Kernel


class OnlineSettings(BaseModel):
    """All that the online correction needs to be told.

    Attributes:
        sample_time_s: time between two steps (s).
        preview: how far ahead an error is predicted.
        window: observations that the process rests on, the newest N.
        kernel: l, σ1² and σ2².
        form: what the process predicts (`error_prediction`).
        gain: α, constant or estimated.
        velocity: how the reference velocity follows u2: by its finite difference, or not at all.
        limit_m: longest correction u2 (m).
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    sample_time_s: PositiveFloat
    preview: Preview
    window: Annotated[int, Field(ge=1, le=1000)]
    kernel: Kernel
    form: FormName
    gain: Gain
    velocity: Literal["finite_difference", "uncorrected"]
    limit_m: PositiveFloat = 1.0


PAPER = OnlineSettings(
    sample_time_s=1 / 7,
    preview=Preview.of_steps((4, 4, 3), 1 / 7),
    window=40,
    kernel=Kernel(prior_variance=1.0, length_scale=20.0, noise_variance=2e-5),
    form="position",
    gain=ConstantGain(alpha=(5.0, 5.0, 0.5)),
    velocity="finite_difference",
)
"""The paper's experiment, number by number ("Online Learning for Bebop")."""

DEFAULT = OnlineSettings(
    sample_time_s=1 / 50,
    preview=Preview.of_time(0.36),
    window=40,
    kernel=Kernel(prior_variance=1.0, length_scale=20.0, noise_variance=2e-5),
    form="displacement",
    gain=ConstantGain(alpha=(3.0, 3.0, 3.0)),
    velocity="uncorrected",
)
"""Ours: seven times the paper's rate, so that the window spans the last second."""
