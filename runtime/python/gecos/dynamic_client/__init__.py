"""Makes proxies at run time, from the model that an object serves, without generated code.

    kind = proxy_class(texts, "robcl::Gripper")
    for member in description_of(kind).members: ...

Values are plain data, as in `gecos.wire.json`. numpy is not imported.
"""

from gecos.dynamic_client.model import (
    Attribute,
    AttributeStream,
    Member,
    Model,
    ModelError,
    Operation,
    Value,
)
from gecos.dynamic_client.proxy import DynamicObject, description_of, proxy_class
from gecos.dynamic_client.read import read_model

__all__ = [
    "Attribute",
    "AttributeStream",
    "DynamicObject",
    "Member",
    "Model",
    "ModelError",
    "Operation",
    "Value",
    "description_of",
    "proxy_class",
    "read_model",
]
