"""Several points at once: which of them are near, as the bits of a number.

Whether one point is near cannot be foreseen, and a wrong guess costs the processor more than asking of several at once.
Numba makes no such code of a loop that writes as it goes, since it cannot know that the arrays are apart. So it is said
in LLVM's words, which hold on any processor; each lane does what the same arithmetic of one point does, bit for bit.
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
    """Return a compiled function that finds which of a number of points are near a place, for kernels.

    It takes an array, the element at which their x begin, how many elements later their y begin, and again their z;
    then x, y and z of the place, and the square of how far is near. Bit k of the uint64 that it returns is point k's.
    """
    vector = ir.VectorType(ir.DoubleType(), lanes)

    def typed(_: Any, array: Any, first: Any, stride: Any, x: Any, y: Any, z: Any, within: Any) -> Any:
        numbers = (types.float64,) * 4
        return types.uint64(array, types.uint64, types.uint64, *numbers), generate

    def generate(context: Any, builder: ir.IRBuilder, signature: Any, values: list[ir.Value]) -> ir.Value:
        """Write the code for one call."""
        data = context.make_array(signature.args[0])(context, builder, values[0]).data
        at, squares = values[1], []
        for place in values[3:6]:
            row = builder.load(builder.bitcast(builder.gep(data, [at]), vector.as_pointer()))
            row.align = 8  # a number's; no more is known
            aside = builder.fsub(row, spread(builder, place, vector))
            squares.append(builder.fmul(aside, aside))
            at = builder.add(at, values[2])
        square = builder.fadd(builder.fadd(squares[0], squares[1]), squares[2])
        near = builder.fcmp_ordered("<", square, spread(builder, values[6], vector))
        return builder.zext(builder.bitcast(near, ir.IntType(lanes)), ir.IntType(64))

    return intrinsic(typed)


def spread(builder: ir.IRBuilder, value: ir.Value, vector: ir.VectorType) -> ir.Value:
    """Return a number in every lane."""
    nothing, whole = ir.Constant(vector, ir.Undefined), ir.IntType(32)
    first = builder.insert_element(nothing, value, whole(0))
    return builder.shuffle_vector(first, nothing, ir.Constant(ir.VectorType(whole, vector.count), [0] * vector.count))


near_of_four, near_of_eight = near_of(4), near_of(8)


@intrinsic
def lowest_bit(_: Any, bits: Any):
    """Return which is the lowest bit of a uint64 that is set; one is."""

    def generate(_: Any, builder: ir.IRBuilder, __: Any, values: list[ir.Value]) -> ir.Value:
        """Write the code for one call."""
        return builder.cttz(values[0], cgutils.true_bit)

    return types.uint64(types.uint64), generate
