"""The meaning of a set of .gidl files: immutable and independent of target languages.

A declaration is known by its scoped name ("robcl::Frame", no leading "::"). Types refer to
declarations by that name, so the model needs no cyclic references; `Model.find` returns the
declaration of a name. The model holds all that rules, the wire layout and targets need, in resolved
form: annotations are interpreted, constants are values, and quality and access include inherited
terms.
"""

from gidl.model.declarations import (
    AnnotationDeclaration,
    AnnotationParameter,
    Bitfield,
    Bitmask,
    Bitset,
    Constant,
    Declaration,
    EnumDeclaration,
    Enumerator,
    ExceptionStruct,
    Extensibility,
    Facts,
    Flag,
    MapsTo,
    Member,
    Struct,
    Typedef,
    Union,
    UnionCase,
)
from gidl.model.files import AnyDeclaration, File, Model
from gidl.model.interfaces import Attribute, Direction, Interface, Operation, Parameter
from gidl.model.types import (
    BUILT_IN,
    Annotation,
    ArrayType,
    EnumValue,
    Location,
    MapType,
    NamedType,
    Primitive,
    PrimitiveType,
    Range,
    SequenceType,
    StringType,
    Type,
    Value,
    within,
)

__all__ = [
    "BUILT_IN",
    "Annotation",
    "AnnotationDeclaration",
    "AnnotationParameter",
    "AnyDeclaration",
    "ArrayType",
    "Attribute",
    "Bitfield",
    "Bitmask",
    "Bitset",
    "Constant",
    "Declaration",
    "Direction",
    "EnumDeclaration",
    "EnumValue",
    "Enumerator",
    "ExceptionStruct",
    "Extensibility",
    "Facts",
    "File",
    "Flag",
    "Interface",
    "Location",
    "MapType",
    "MapsTo",
    "Member",
    "Model",
    "NamedType",
    "Operation",
    "Parameter",
    "Primitive",
    "PrimitiveType",
    "Range",
    "SequenceType",
    "StringType",
    "Struct",
    "Type",
    "Typedef",
    "Union",
    "UnionCase",
    "Value",
    "within",
]
