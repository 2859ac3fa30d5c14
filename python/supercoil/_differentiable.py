"""Observables of equilibria as a function of parameters, with derivatives for optimisers, PyTorch and JAX."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .state import Floats, State


class Equilibria:
    """Observables as a function of parameters, q(p): m of the equilibria that ``run`` finds for n parameters.

    ``run`` takes (n,) values and returns a :class:`State`; ``of`` and ``to`` name the observables and the parameters that
    the values stand for, as in :meth:`State.gradient`. A parameter that ``run`` sets in several places is not one name:
    its derivative is the sum of theirs. Derivatives are by the adjoint: one solve an observable, whatever n.
    """

    def __init__(self, run: Callable[[Floats], State], of: Sequence[str], to: Sequence[str]) -> None:
        self._run = run
        self._of = list(of)
        self._to = list(to)

    def __call__(self, values: ArrayLike) -> Floats:
        """(m,) observables."""
        return self.with_jacobian(values)[0]

    def with_jacobian(self, values: ArrayLike) -> tuple[Floats, Floats]:
        """(m,) observables [each in its unit] and (m, n) derivatives for the parameters' (n,) ``values``.

        Raises :class:`InputError` for names that are not those of :meth:`State.gradient`, and whatever ``run`` raises.
        """
        state = self._run(np.array(values, dtype=np.float64))
        return state.values_and_gradients(self._of, self._to)

    def torch(self) -> Callable[[Any], Any]:
        """The function for tensors, (n,) to (m,), as a ``torch.autograd.Function``; needs PyTorch."""
        import torch

        equilibria = self

        class Function(torch.autograd.Function):  # type: ignore[misc, unused-ignore]
            @staticmethod
            def forward(ctx: Any, values: Any) -> Any:
                found, jacobian = equilibria.with_jacobian(values.detach().cpu().numpy())
                ctx.save_for_backward(torch.as_tensor(jacobian).to(values))
                return torch.as_tensor(found).to(values)

            @staticmethod
            def backward(ctx: Any, weights: Any) -> Any:
                (jacobian,) = ctx.saved_tensors
                return weights @ jacobian

        apply: Callable[[Any], Any] = Function.apply
        return apply

    def jax(self) -> Callable[[Any], Any]:
        """The function for arrays, (n,) to (m,), with a ``jax.custom_vjp``; needs JAX. May be compiled: it calls back."""
        import jax
        import jax.numpy as jnp

        rows, columns = len(self._of), len(self._to)

        def both(values: Any) -> Any:
            kind = values.dtype
            shapes = (jax.ShapeDtypeStruct((rows,), kind), jax.ShapeDtypeStruct((rows, columns), kind))

            def found(plain: Any) -> Any:
                return tuple(np.asarray(part, dtype=kind) for part in self.with_jacobian(plain))

            return jax.pure_callback(found, shapes, values)

        def value(values: Any) -> Any:
            return both(values)[0]

        def forward(values: Any) -> Any:
            return both(values)

        def backward(jacobian: Any, weights: Any) -> Any:
            return (jnp.matmul(weights, jacobian),)

        function: Any = jax.custom_vjp(value)
        function.defvjp(forward, backward)
        result: Callable[[Any], Any] = function
        return result
