"""Settings of the online correction: the paper's, and ours."""

from typing import Annotated, Literal, Self, TypeAlias

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    NonNegativeFloat,
    PositiveFloat,
    Tag,
    model_validator,
)

from companion.learning.correction import ConstantGain, EstimatedGain, Gain, StiffnessGain
from companion.learning.error_prediction import FORMS, FormName
from companion.learning.features import Preview
from companion.learning.gaussian_process import Kernel
from companion.learning.motion_model import LinearKernel

_Lead: TypeAlias = Annotated[float, Field(ge=0.0, le=1.0)]


class ReferenceLead(BaseModel):
    """How much early each part of a reference is sent (s), sideways and up or down.

    Setpoints take their time, and a multirotor must tilt before it accelerates sideways; up and down thrust
    alone does it, and autopilots damp that motion harder: an early velocity asks for more there.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    position_s: _Lead = 0.0
    velocity_s: _Lead = 0.0
    acceleration_s: _Lead = 0.0
    vertical_position_s: _Lead = 0.0
    vertical_velocity_s: _Lead = 0.0
    vertical_acceleration_s: _Lead = 0.0


def _kind_of_kernel(kernel: object) -> str:
    has_length = isinstance(kernel, Kernel) or (isinstance(kernel, dict) and "length_scale" in kernel)
    return "squared exponential" if has_length else "linear"


class OnlineSettings(BaseModel):
    """All that the online correction needs to be told.

    Attributes:
        sample_time_s: time between two steps (s).
        preview: how far ahead an error is predicted.
        window: observations that the process rests on, the newest N.
        kernel: σ1², σ2², and l but where the process is linear.
        form: what the process predicts (`error_prediction`), or `motion`, which is linear (`motion_model`).
        gain: α: constant, estimated, or by the stiffness that is wanted (`correction`).
        longest_m: u2 is scaled down to this length (m): an error that takes more shows a vehicle at its
            limits, and the correction would only drive it against them.
        sideways_m_s2: the horizontal pull of the correction is scaled down to this: autopilots accelerate
            only so much (ArduPilot's WPNAV_ACCEL, 2.5 m/s²), and what they do not obey makes errors swing.
        corrected: the whole predicted error, as in the paper, or what of it comes of the vehicle's deviation
            from its trajectory: the error at the operating point, the trajectory itself, is taken off. It is
            a matter of u1, and from ten seconds of flight near the trajectory badly known.
        velocity: how the reference velocity is corrected: by the finite difference of u2, by the predicted
            velocity error so that it calls for `damping_1_s`, and by the estimate's slow drift
            (`flight.drift`), or not at all.
        damping_1_s: acceleration for a predicted velocity error (1/s).
        vertical_integral_1_s: how fast the vertical tracking error is integrated (1/s), against weight and
            thrust that have changed (`flight.vertical_integral`); 0: not.
        lead: how much early the reference is sent on which the correction rests.
        caution: how much an innovation counts against a predicted error (`correction.Confidence`); 0: not.
        velocity_caution: the same of the velocity, where the estimate's slow drift counts as innovation too.
        variance_caution: how much the model's variance counts against each single predicted error
            (`correction.certain_share`); 0: not.
        memory: steps over which that is judged, and states over which the lateness of the link is averaged.
        network_share: how far `dnn+gp` follows the network instead of the plain reference, above 0 to 1,
            before it is known what that does; 1 is the paper's law (`blends_networks`).
        harm_memory_s: over how long it is measured what network and correction do (`negative_transfer`),
            which their shares follow (s); 0: not.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    sample_time_s: Annotated[float, Field(ge=0.005, le=0.2)]
    preview: Preview
    window: Annotated[int, Field(ge=1, le=1000)]
    kernel: Annotated[
        Annotated[Kernel, Tag("squared exponential")] | Annotated[LinearKernel, Tag("linear")],
        Discriminator(_kind_of_kernel),
    ]
    form: FormName | Literal["motion"]
    gain: Gain
    corrected: Literal["error", "deviation"] = "error"
    longest_m: PositiveFloat = 1.0
    sideways_m_s2: PositiveFloat = 100.0
    velocity: Literal["finite_difference", "predicted", "uncorrected"]
    damping_1_s: Annotated[float, Field(ge=0.0, le=50.0)] = 0.0
    vertical_integral_1_s: Annotated[float, Field(ge=0.0, le=5.0)] = 0.0
    lead: ReferenceLead = ReferenceLead()
    caution: NonNegativeFloat = 0.0
    velocity_caution: NonNegativeFloat = 0.0
    variance_caution: NonNegativeFloat = 0.0
    memory: Annotated[int, Field(ge=1, le=100_000)] = 100
    network_share: Annotated[float, Field(gt=0.0, le=1.0)] = 1.0
    harm_memory_s: NonNegativeFloat = 0.0

    @property
    def blends_networks(self) -> bool:
        """Whether `dnn+gp` follows networks by a judged share; else one is all of u1, as in the paper."""
        return self.network_share < 1.0

    @property
    def judges_networks(self) -> bool:
        """Whether it is measured what networks do, so that one of several can be chosen by it."""
        return self.blends_networks and self.harm_memory_s > 0.0

    @model_validator(mode="after")
    def _form_fits(self) -> Self:
        if (self.form == "motion") != isinstance(self.kernel, LinearKernel):
            raise ValueError("form motion takes a kernel without length_scale, every other form one with it")
        if isinstance(self.kernel, Kernel) and self.form != "motion":
            scales, inputs = self.kernel.length_scale, FORMS[self.form].size
            if isinstance(scales, tuple) and len(scales) != inputs:
                raise ValueError(
                    f"form {self.form} has {inputs} inputs: length_scale takes one value, or {inputs}"
                )
        if self.form == "motion" and min(self.preview.position_s) <= 0.0:
            raise ValueError("form motion predicts ahead: preview.position_s must be above 0")
        return self


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
    preview=Preview.of_time(0.18),
    window=500,
    kernel=LinearKernel(prior_variance=1.0, noise_variance=0.02),
    form="motion",
    gain=StiffnessGain(stiffness_1_s2=32.0),
    corrected="deviation",
    longest_m=0.95,  # within the guard's usual limit
    sideways_m_s2=2.0,
    velocity="predicted",
    damping_1_s=10.0,
    vertical_integral_1_s=0.5,
    lead=ReferenceLead(
        position_s=0.03,
        velocity_s=0.06,
        acceleration_s=0.15,
        vertical_position_s=0.02,
        vertical_velocity_s=0.03,
        vertical_acceleration_s=0.06,
    ),
    velocity_caution=2.0,
    network_share=0.3,
    harm_memory_s=3.0,
)
"""Ours: the model that predicts real flights best, from constant velocity by ten seconds of flight; a preview
at which a small predicted error says much, and gains to match. The velocity is corrected as far as it can be
believed. See docs/decisions.md."""

ESTIMATED = DEFAULT.model_copy(
    update={
        "preview": Preview.of_time(0.36),
        "gain": EstimatedGain(least=1.0, most=4.0),
        "corrected": "error",
        "velocity": "uncorrected",
        "velocity_caution": 0.0,
        "damping_1_s": 0.0,
        "vertical_integral_1_s": 0.0,
        "variance_caution": 1.0,
    }
)
"""Ours, with the gain that the online model itself gives at every step (Insight 1), and a longer preview.
Gain and correction are limited by how uncertain the model is of the gradient and of the error."""
