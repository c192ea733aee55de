"""Tuples of arrays that compiled code takes by reference.

Numba passes a tuple by value: some fifty arrays are four hundred arguments of every function, packed and
unpacked at each call.  That is a third of the compiler's time and a fifth of a step's.  Here kernels get the
address of an image of the tuple, and load from it the arrays that they use.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
from llvmlite import ir
from numba import config, typeof, types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.imputils import impl_ret_borrowed
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    infer_getattr,
    intrinsic,
    lower_getattr_generic,
    register_model,
    typeof_impl,
    unbox,
)

from .kernel import kernel

Values = TypeVar("Values", bound=NamedTuple)


class ReferenceType(types.Type):
    """Numba's type of a reference to a tuple of the type `values`."""

    def __init__(self, values: types.NamedTuple) -> None:
        self.values = values
        super().__init__(name=f"Reference({values.name})")


class Reference:
    """A named tuple and the image of it that compiled code reads; its fields are attributes here too."""

    def __init__(self, values: Any) -> None:
        self.values = values
        self.__dict__.update(values._asdict())
        self.kind = ReferenceType(typeof(values))
        self.image = np.zeros(image_size(values), dtype=np.uint8)
        self.address = self.image.ctypes.data
        write_image(values, self.image)


def by_reference(values: Values) -> Values:
    """What behaves as the named tuple of arrays, and is handed to kernels by reference."""
    return values if config.DISABLE_JIT else cast(Values, Reference(values))


@register_model(ReferenceType)
class ReferenceModel(models.PrimitiveModel):
    """A pointer to the tuple."""

    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, dmm.lookup(fe_type.values).get_value_type().as_pointer())


@typeof_impl.register(Reference)
def type_of_reference(value, _context):
    """Numba's type of a reference."""
    return value.kind


@unbox(ReferenceType)
def unbox_reference(kind, value, c):
    """The address that a reference holds."""
    address = c.pyapi.object_getattr_string(value, "address")
    pointer = c.pyapi.long_as_longlong(address)
    c.pyapi.decref(address)
    failed = cgutils.is_not_null(c.builder, c.pyapi.err_occurred())
    return NativeValue(c.builder.inttoptr(pointer, c.context.get_value_type(kind)), is_error=failed)


@infer_getattr
class ReferenceAttribute(AttributeTemplate):
    """The fields of a reference are those of its tuple."""

    key = ReferenceType

    def generic_resolve(self, reference, name):
        """Type of a field."""
        values = reference.values
        return values.types[values.fields.index(name)] if name in values.fields else None


@lower_getattr_generic(ReferenceType)
def load_field(context, builder, kind, pointer, name):
    """Load a field from the image."""
    k = kind.values.fields.index(name)
    field = builder.load(cgutils.gep_inbounds(builder, pointer, 0, k))
    return impl_ret_borrowed(context, builder, kind.values.types[k], field)


@intrinsic
def size_of(_typing, values):
    """Bytes of a tuple."""

    def code(context, _builder, signature, _arguments):
        size = context.get_abi_sizeof(context.get_value_type(signature.args[0]))
        return ir.Constant(ir.IntType(64), size)

    return types.int64(values), code


@intrinsic
def store(_typing, values, image):
    """Write a tuple into a buffer, its arrays without their counters: the Reference keeps them alive."""

    def code(context, builder, signature, arguments):
        values, counters = arguments[0], ("meminfo", "parent")
        for k, kind in enumerate(signature.args[0].types):
            if not isinstance(kind, types.Array):
                continue
            array = context.make_array(kind)(context, builder, builder.extract_value(values, k))
            for counter in counters:
                setattr(array, counter, cgutils.get_null_value(getattr(array, counter).type))
            values = builder.insert_value(values, array._getvalue(), k)
        buffer = context.make_array(signature.args[1])(context, builder, arguments[1])
        builder.store(values, builder.bitcast(buffer.data, values.type.as_pointer()))
        return context.get_dummy_value()

    return types.void(values, image), code


@kernel
def image_size(values):
    """Bytes that the image of a tuple takes."""
    return size_of(values)


@kernel
def write_image(values, image):
    """Write the image of a tuple into a buffer."""
    store(values, image)
