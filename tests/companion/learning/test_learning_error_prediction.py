import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.arrays import Vec3
from companion.learning.error_prediction import FORMS, ErrorModel, FormName, Step
from companion.learning.features import ERROR_INPUTS
from companion.learning.gaussian_process import Kernel

KERNEL = Kernel(prior_variance=1.0, length_scale=20.0, noise_variance=1e-6)
FORM_NAMES: list[FormName] = ["error", "position", "displacement"]
GAIN = np.diag([0.8, 0.6, 0.4])


def random_step(rng: np.random.Generator, where: float = 0.0) -> Step:
    position = rng.normal(size=3) + where
    state = np.concatenate((position, rng.normal(scale=0.3, size=9)))
    return Step(
        state,
        *(position + rng.normal(size=3), rng.normal(size=3)),
        position + rng.normal(size=3),
        *np.zeros((5, 3)),
    )


def outcome(step: Step) -> Vec3:
    """y(k+r) of a linear vehicle (Eqn. inputOuputLinear)."""
    position, velocity = step.state[:3], step.state[3:6]
    return position + 0.3 * velocity + GAIN @ (step.reference_position - position)


def velocity_after(step: Step) -> Vec3:
    return step.state[3:6] + 0.5 * step.reference_velocity


def trained(form: FormName, where: float = 0.0) -> ErrorModel:
    model = ErrorModel(form, KERNEL, window=120)
    rng = np.random.default_rng(0)
    for _ in range(120):
        step = random_step(rng, where)
        assert model.learn(step, outcome(step), velocity_after(step))
    return model


@pytest.mark.parametrize("form", FORM_NAMES)
def test_every_form_predicts_error_and_gradient(form: FormName) -> None:
    step = random_step(np.random.default_rng(1))
    predicted = trained(form).predict(step)
    np.testing.assert_allclose(predicted.position, outcome(step), atol=0.03)
    np.testing.assert_allclose(predicted.error, step.desired_position - outcome(step), atol=0.03)
    np.testing.assert_allclose(predicted.velocity, velocity_after(step), atol=0.03)
    np.testing.assert_allclose(predicted.velocity_error, -velocity_after(step), atol=0.03)
    np.testing.assert_allclose(predicted.gradient, -GAIN, atol=0.05)
    assert 0.0 <= predicted.variance < 0.01
    assert (predicted.gradient_variance < 0.01**2).all()


@pytest.mark.parametrize("form", FORM_NAMES)
def test_the_gradient_is_that_of_the_error(form: FormName) -> None:
    model, step, small = trained(form), random_step(np.random.default_rng(2)), 1e-4
    for axis, unit in enumerate(np.eye(3)):
        ahead, behind = (
            model.predict(
                step._replace(reference_position=step.reference_position + sign * small * unit)
            ).error
            for sign in (1.0, -1.0)
        )
        gradient = model.predict(step).gradient[:, axis]
        np.testing.assert_allclose(gradient, (ahead - behind) / (2.0 * small), atol=1e-5)


@given(st.floats(-1000.0, 1000.0))
def test_displacement_holds_wherever_it_is_flown(where: float) -> None:
    near = trained_displacement.predict(random_step(np.random.default_rng(3)))
    far = trained_displacement.predict(random_step(np.random.default_rng(3), where))
    np.testing.assert_allclose(far.error, near.error, atol=1e-8)


trained_displacement = trained("displacement")


def test_what_an_ignorant_model_expects() -> None:
    step = random_step(np.random.default_rng(4), where=10.0)
    expected = {"error": step.desired_position, "position": np.zeros(3), "displacement": step.state[:3]}
    for form in FORM_NAMES:
        predicted = ErrorModel(form, KERNEL, window=5).predict(step)
        np.testing.assert_array_equal(predicted.position, expected[form])
        assert predicted.variance == KERNEL.prior_variance


def test_the_papers_inputs() -> None:
    step = random_step(np.random.default_rng(5))
    position = FORMS["position"]
    np.testing.assert_array_equal(position.inputs(step), np.concatenate(step[:5]))
    assert ERROR_INPUTS[position.reference] == tuple(
        f"reference_position.{axis}" for axis in ("north", "east", "down")
    )


@pytest.mark.parametrize("form", FORM_NAMES)
def test_what_is_not_finite_is_not_learned(form: FormName) -> None:
    model, step = ErrorModel(form, KERNEL, window=5), random_step(np.random.default_rng(6))
    assert not model.learn(step, np.array([0.0, np.nan, 0.0]), np.zeros(3))
    assert not model.learn(step._replace(reference_position=np.full(3, np.inf)), np.zeros(3), np.zeros(3))
    assert len(model) == 0
