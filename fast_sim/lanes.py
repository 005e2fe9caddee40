"""Vector lanes: tests of several points at once, with the results as the bits of a number.

The processor cannot predict whether a point is near, and a misprediction costs more than testing several points at
once. Numba does not vectorise a loop that writes its results, since it cannot know that the arrays do not overlap. So
this code is written in LLVM's instructions, which work on any processor; each lane does the same arithmetic as for one
point, bit for bit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

MOST_LANES = 8


def near_of(lanes: int) -> Callable[..., Any]:
    """Return a function, for kernels, that finds which of ``lanes`` points are near a place.

    Its arguments are an array, the index of the first x coordinate, the offset from the x to the y and from the y to
    the z coordinates, the coordinates x, y and z of the place, and the squared distance. Bit k of the returned uint64
    is set if point k is near.
    """
    vector = ir.VectorType(ir.DoubleType(), lanes)

    def typed(_: Any, array: Any, first: Any, stride: Any, x: Any, y: Any, z: Any, within: Any) -> Any:
        numbers = (types.float64,) * 4
        return types.uint64(array, types.uint64, types.uint64, *numbers), generate

    def generate(context: Any, builder: ir.IRBuilder, signature: Any, values: list[ir.Value]) -> ir.Value:
        """Generate the code of one call."""
        data = context.make_array(signature.args[0])(context, builder, values[0]).data
        at, squares = values[1], []
        for place in values[3:6]:
            row = builder.load(builder.bitcast(builder.gep(data, [at]), vector.as_pointer()))
            row.align = 8  # that of a single number
            aside = builder.fsub(row, spread(builder, place, vector))
            squares.append(builder.fmul(aside, aside))
            at = builder.add(at, values[2])
        square = builder.fadd(builder.fadd(squares[0], squares[1]), squares[2])
        near = builder.fcmp_ordered("<", square, spread(builder, values[6], vector))
        return builder.zext(builder.bitcast(near, ir.IntType(lanes)), ir.IntType(64))

    return intrinsic(typed)


def spread(builder: ir.IRBuilder, value: ir.Value, vector: ir.VectorType) -> ir.Value:
    """Return a vector with a number in every lane."""
    nothing, whole = ir.Constant(vector, ir.Undefined), ir.IntType(32)
    first = builder.insert_element(nothing, value, whole(0))
    return builder.shuffle_vector(first, nothing, ir.Constant(ir.VectorType(whole, vector.count), [0] * vector.count))


near_of_four, near_of_eight = near_of(4), near_of(8)


@intrinsic
def lowest_bit(_: Any, bits: Any):
    """Return the number of the lowest set bit of a uint64, which must not be 0."""

    def generate(_: Any, builder: ir.IRBuilder, __: Any, values: list[ir.Value]) -> ir.Value:
        """Generate the code of one call."""
        return builder.cttz(values[0], cgutils.true_bit)

    return types.uint64(types.uint64), generate
