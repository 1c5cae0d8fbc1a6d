"""Robots with two arms: files that describe them, and models made of them."""
