"""Generates code for Python 3.11: slotted dataclasses that encode themselves, client proxies and
servants."""
