"""TOML text to checked tables; pydantic's errors to one line each."""
from __future__ import annotations

import os
import re
import tomllib
from typing import Any

from pydantic import ValidationError

from .errors import SceneFileError, key_of, shown
from .models import SceneTable


def read(path: str | os.PathLike[str]) -> SceneTable:
    """The tables of a scene file."""
    with open(path, "rb") as file:
        content = file.read()
    try:
        data = tomllib.loads(content.decode("utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise SceneFileError(path, "", f"not TOML: {error}") from None
    except UnicodeDecodeError as error:
        raise SceneFileError(path, "", f"not UTF-8 text, at byte {error.start}") from None
    except RecursionError:
        raise SceneFileError(path, "", "not a scene: nested too deeply") from None
    try:
        return SceneTable.model_validate(data)
    except ValidationError as error:
        key, problem = described(error, data)
        raise SceneFileError(path, key, problem) from None


def described(refused: ValidationError, data: Any) -> tuple[str, str]:
    """Key and problem of the first of pydantic's errors."""
    error: Any = refused.errors(include_url=False)[0]
    kind, context = error["type"], error.get("ctx", {})
    location = _in_file(error["loc"], data)
    if kind == "unknown_key":
        return key_of([*location, context["key"]]), error["msg"]
    if kind == "missing":
        return key_of([*location, error["loc"][-1]]), "is missing"
    if kind == "union_tag_not_found":
        return key_of([*location, "type"]), "is missing" if isinstance(error["input"], dict) else "must be a table"
    if kind == "union_tag_invalid":
        allowed = context["expected_tags"].replace("'", "")
        return key_of([*location, "type"]), f"{shown(context['tag'])}: unknown type (allowed: {allowed})"
    return key_of(location), f"{shown(error['input'])}: {_allowed(error['msg'])}"


def _in_file(location: tuple[str | int, ...], data: Any) -> list[str | int]:
    """pydantic's location without the parts that are names of union members and not in the file."""
    found: list[str | int] = []
    tagged: Any = None  # the table whose `type` was the last part: "quads" is a type, and a key of tables of that type
    for part in location:
        if isinstance(data, dict) and data.get("type") == part and data is not tagged:
            tagged = data
            continue
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            continue
        found.append(part)
    return found


def _allowed(message: str) -> str:
    """pydantic's message as "must be …"."""
    message = re.sub(r"^(Input|Value|List|Tuple|String|Dictionary) should ", "must ", message)
    return message[0].lower() + message[1:]
