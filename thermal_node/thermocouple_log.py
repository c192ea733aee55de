"""A test's log, under the name that users import."""

from .furnace.thermocouple_log import ThermocoupleLog, read_thermocouple_log

__all__ = ["ThermocoupleLog", "read_thermocouple_log"]
