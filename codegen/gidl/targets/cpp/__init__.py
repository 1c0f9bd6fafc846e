"""Generates C++20: types that encode themselves, client proxies, servant skeletons."""
