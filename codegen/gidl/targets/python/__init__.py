"""Generates Python 3.11: slotted dataclasses that encode themselves, client proxies, servants."""
