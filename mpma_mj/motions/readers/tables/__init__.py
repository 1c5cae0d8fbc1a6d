"""Readers of tables, whose columns have titles: coordinates or joint angles, frame by frame."""
