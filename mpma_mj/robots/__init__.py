"""Robots with two arms of four hinges each: their files, models and kinematics."""
