"""Robots with two arms of four hinges each: kinematics of any such arm."""
