"""The version of the package, for those below what the package offers."""

__version__ = "0.1.0"
