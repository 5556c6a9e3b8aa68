"""Tracing of kernels, functions of single components, into straight-line programs.

A kernel takes a `Geometry` and tensors with the samples as the last dimension. It calculates with
rows of samples, and with plain numbers where the geometry knows them: zeros, ones and lengths.
Tracing it once removes products with 0 and 1, sums with 0, unused operations, and all Python
between the operations.
"""

import operator
from collections.abc import Callable, Iterable
from functools import cache
from inspect import signature
from typing import Any, NamedTuple

import torch
from torch import fx

Number = Any
"""A row of samples (N,), a single value of a tensor, or a float."""

Kernel = Callable[..., Any]


class Tail(NamedTuple):
    """A link's constant transform, after its joint: rotation matrix by rows, and lever [m]."""

    rotation: tuple[tuple[float, ...], ...]
    lever: tuple[float, ...]


class Geometry(NamedTuple):
    """The constants of an arm of n joints: tails of links 1 to n, gravity [m/s²]."""

    tails: tuple[Tail, ...]
    gravity: tuple[float, float, float]

    @property
    def joints(self) -> range:
        """Return the joints, counted from 0."""
        return range(len(self.tails))


@cache
def straight_line(kernel: Kernel, geometry: Geometry) -> fx.GraphModule:
    """Return the program of a kernel for one geometry: a function of the kernel's tensors."""
    tracer = _Tracer()
    names = list(signature(kernel).parameters)[1:]
    inputs = [tracer.create_proxy("placeholder", name, (), {}) for name in names]
    tracer.graph.output(tracer.create_arg(kernel(geometry, *inputs)))
    tracer.graph.eliminate_dead_code()
    return fx.GraphModule({}, tracer.graph)


def stacked(values: Iterable[Number], like: Number) -> Any:
    """Stack m numbers as rows (m, N) of the length of `like`; constants are broadcast."""
    zeros = torch.zeros_like(like)
    rows = [zeros if _is(value, 0) else value for value in values]
    return torch.stack(torch.broadcast_tensors(like, *rows)[1:])


class _Tracer(fx.Tracer):
    def __init__(self) -> None:
        super().__init__()
        self.graph = fx.Graph()
        self.root = torch.nn.Module()  # a kernel has no state
        self.known: dict[tuple[Any, ...], fx.Proxy] = {}

    def proxy(self, node: fx.Node) -> fx.Proxy:
        return _Term(node, self)


class _Term(fx.Proxy):
    """An operation of the traced program; operations with 0 and 1 are simplified."""

    tracer: "_Tracer"

    def __add__(self, other: Number) -> Number:
        if _is(other, 0):
            return self
        for summand, product in ((self, other), (other, self)):
            if _is_product(product) and isinstance(summand, _Term):
                return self._recorded(torch.addcmul, summand, *product.node.args)
        return self._recorded(operator.add, self, other)

    def __sub__(self, other: Number) -> Number:
        if _is(other, 0):
            return self
        if _is_product(other):
            return self._recorded(torch.addcmul, self, *other.node.args, value=-1)
        return self._recorded(operator.sub, self, other)

    def __rsub__(self, other: Number) -> Number:
        return -self if _is(other, 0) else self._recorded(operator.sub, other, self)

    def __neg__(self) -> Number:
        return self._recorded(operator.neg, self)

    def __mul__(self, other: Number) -> Number:
        if _is(other, 0):
            return 0.0
        if _is(other, 1):
            return self
        return -self if _is(other, -1) else self._recorded(operator.mul, self, other)

    __radd__ = __add__
    __rmul__ = __mul__

    def _recorded(
        self, operation: Callable[..., Any], *operands: Number, **options: Number
    ) -> Number:
        """Record an operation; the same on the same operands is recorded once."""
        nodes = tuple(getattr(operand, "node", operand) for operand in operands)
        key = (operation, *nodes, *options.items())
        if key not in self.tracer.known:
            node = self.tracer.graph.call_function(operation, nodes, options)
            self.tracer.known[key] = self.tracer.proxy(node)
        return self.tracer.known[key]


def _is_product(value: Number) -> bool:
    """Return whether a value is a product of two rows, which addcmul can multiply and add."""
    return (
        isinstance(value, _Term)
        and value.node.target is operator.mul
        and all(isinstance(factor, fx.Node) for factor in value.node.args)
    )


def _is(value: Number, number: int) -> bool:
    return isinstance(value, float) and value == number
