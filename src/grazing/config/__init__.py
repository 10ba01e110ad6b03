"""Configurations: one schema for files, options, help and the recipes that results and stores keep."""

from grazing.config.build import boundaries_of, plan_of, result_of
from grazing.config.check import checked
from grazing.config.command import command_of
from grazing.config.files import load_config, toml_of
from grazing.config.origin import recipe_of
from grazing.config.schema import json_schema

__all__ = [
    "boundaries_of", "checked", "command_of", "json_schema", "load_config", "plan_of", "recipe_of", "result_of",
    "toml_of",
]  # fmt: skip
