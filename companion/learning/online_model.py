"""What every online model can be asked, and which one some settings mean."""

from typing import Protocol

from companion.arrays import Vec3
from companion.learning.error_prediction import ErrorModel, PredictedError, Step
from companion.learning.gaussian_process import Kernel
from companion.learning.motion_model import LinearKernel, MotionModel
from companion.learning.online_settings import OnlineSettings


class OnlineModel(Protocol):
    """Learns from steps whose outcome was flown, predicts that of the present one."""

    def __len__(self) -> int:
        """How many observations it rests on."""
        ...

    def learn(self, step: Step, flown_position: Vec3, flown_velocity: Vec3) -> bool:
        """Take in where `step` (with the reference as sent) led to; False if that is not finite."""
        ...

    def predict(self, step: Step) -> PredictedError:
        """The error that `step` leads to; NaN, never an exception, if the step is not finite."""
        ...


def online_model(settings: OnlineSettings) -> OnlineModel:
    """A new model, which knows nothing yet."""
    if settings.form == "motion":
        assert isinstance(settings.kernel, LinearKernel)
        return MotionModel(settings.kernel, settings.window, settings.preview)
    assert isinstance(settings.kernel, Kernel)
    return ErrorModel(settings.form, settings.kernel, settings.window)
